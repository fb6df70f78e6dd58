/* keys by falling value, equal ones in their order, and their places, by merging; the last two arrays are room */
static void put_in_order(double *keys, double *places, int count, double *more_keys, double *more_places)
{
    int width = 1;
    while (width < count) {
        int low = 0;
        while (low < count) {
            const int middle = low + width < count ? low + width : count;
            const int high = middle + width < count ? middle + width : count;
            int i = low;
            int j = middle;
            for (int k = low; k < high; k++) {
                const int is_first = i < middle && (j == high || keys[i] >= keys[j]) ? 1 : 0;
                const int from = is_first == 1 ? i : j;
                more_keys[k] = keys[from];
                more_places[k] = places[from];
                i += is_first;
                j += 1 - is_first;
            }
            low = high;
        }
        for (int k = 0; k < count; k++) {
            keys[k] = more_keys[k];
            places[k] = more_places[k];
        }
        width += width;
    }
}

/* the copies of branch b, the last joint turned first, as rows from `row` on behind place `begin` of `out`; gives the
   row after them */
static int branch_rows(const double *found, int b, int row, double *margins, double *places, double *out, int begin)
{
    double turn[JOINTS];
    const int at = JOINTS * b;
    const int is_inside = found[COPIES + b] > 0.0 ? 1 : 0;
    const int end = is_inside == 1 ? row + (int)found[COPIES + b] : row + 1;
    for (int i = 0; i < JOINTS; i++) {
        turn[i] = is_inside == 1 ? found[FIRST + at + i] : 0.0;
    }
    for (int k = row; k < end; k++) {
        const int to = begin + (JOINTS + 3) * k;
        double margin = 0.0;
        double joint = 0.0;
        for (int i = 0; i < JOINTS; i++) {
            const double q = found[at + i] + TURN * turn[i];
            const double room = smaller(UP[i] - q, q - LOW[i]);
            if (i == 0 || room < margin) {
                margin = room;
                joint = i;
            }
            out[to + i] = q;
        }
        out[to + JOINTS] = margin;
        out[to + JOINTS + 1] = joint;
        out[to + JOINTS + 2] = b;
        margins[k] = margin;
        places[k] = k;
        int i = JOINTS - 1;
        turn[i] += 1.0;
        while (i > 0 && turn[i] >= found[FIRST + at + i] + found[MANY + at + i]) {
            turn[i] = found[FIRST + at + i];
            i--;
            turn[i] += 1.0;
        }
    }
    return end;
}

/* all copies that `solutions` has found, by falling margin: q, margin, the joint that has it, branch; then in the order
   of the branches, as room; gives how many */
int rows(double *found, double *out)
{
    double margins[2048];
    double places[2048];
    double more_margins[2048];
    double more_places[2048];
    const int width = JOINTS + 3;
    const int count = (int)(found[INSIDE] + found[OUTSIDE]);
    int row = 0;
    if (IS_CHECKED == 0) {
        residuals(found);
    }
    for (int b = 0; b < 8; b++) {
        if (found[JOINTS * b] <= UNLIMITED) {
            row = branch_rows(found, b, row, margins, places, out, width * count);
        }
    }
    put_in_order(margins, places, count, more_margins, more_places);
    for (int k = 0; k < count; k++) {
        const int from = width * (count + (int)places[k]);
        for (int i = 0; i < width; i++) {
            out[width * k + i] = out[from + i];
        }
    }
    return count;
}
