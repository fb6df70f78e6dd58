/* a matrix (count, count) of rows WAVES apart, from place `entry` on, along the joint whose values are `inner` apart */
static void contract(const double *matrix, int entry, double *pool, int from, int to, int size, int inner, int count)
{
    int start = 0;
    while (start < size) {
        for (int m = 0; m < count; m++) {
            const int at = to + start + m * inner;
            const double first = matrix[entry + m * WAVES];
            for (int y = 0; y < inner; y++) {
                pool[at + y] = first * pool[from + start + y];
            }
            for (int k = 1; k < count; k++) {
                const double a = matrix[entry + m * WAVES + k];
                if (a != 0.0) {
                    for (int y = 0; y < inner; y++) {
                        pool[at + y] += a * pool[from + start + k * inner + y];
                    }
                }
            }
        }
        start += count * inner;
    }
}

/* the largest second difference of a box's control values along one joint */
static double bend(const double *pool, int box, int size, int inner, int count)
{
    double most = 0.0;
    int start = 0;
    while (start < size) {
        for (int y = box + start + inner; y < box + start + (count - 1) * inner; y++) {
            most = larger(most, fabs(pool[y - inner] - 2.0 * pool[y] + pool[y + inner]));
        }
        start += count * inner;
    }
    return most;
}

/* the bound over the box in the first row of the pool: bound, best value met, boxes */
int search(const double *counts, int d, const double *lefts, int unused, const double *rights, int rows,
           const double *corners, int corner_count, double *levels, int size, const double *asked, int most,
           double *out, double *pool, int start, int stop)
{
    const double gap = asked[0];
    double known = asked[1];
    double bound = -INFINITE;
    int boxes = 0;
    int top = 0;
    for (int j = 0; j < d; j++) {
        levels[j] = 0.0;
    }
    while (top >= 0) {
        boxes += 1;
        const int box = top * size;
        double highest = pool[box];
        for (int x = 0; x < size; x++) {
            highest = larger(highest, pool[box + x]);
        }
        for (int x = 0; x < corner_count; x++) {
            known = larger(known, pool[box + (int)corners[x]]);
        }
        /* halved along the joint whose control values bend most; not where none bends any more */
        int chosen = -1;
        int its_inner = 1;
        if (highest > known * (1.0 + gap) && boxes < most && top + 1 < rows) {
            double largest = 0.0;
            int inner = 1;
            for (int back = 0; back < d; back++) {
                const int j = d - 1 - back;
                const int count = (int)counts[j];
                if (levels[top * d + j] < LEVELS) {
                    const double here = bend(pool, box, size, inner, count);
                    if (here > largest) {
                        chosen = j;
                        its_inner = inner;
                        largest = here;
                    }
                }
                inner = inner * count;
            }
        }
        if (chosen < 0) {
            bound = larger(bound, highest);
            top -= 1;
        } else {
            const int count = (int)counts[chosen];
            const int entry = (chosen * LEVELS + (int)levels[top * d + chosen]) * WAVES * WAVES;
            for (int x = 0; x < size; x++) {
                pool[rows * size + x] = pool[box + x];
            }
            contract(lefts, entry, pool, rows * size, box + size, size, its_inner, count);
            contract(rights, entry, pool, rows * size, box, size, its_inner, count);
            levels[top * d + chosen] += 1.0;
            for (int j = 0; j < d; j++) {
                levels[(top + 1) * d + j] = levels[top * d + j];
            }
            top += 1;
        }
    }
    out[0] = bound;
    out[1] = known;
    out[2] = boxes;
    return 0;
}
