/* the pose with the nearest rotation; gives 1 where it is no pose (Newton steps of the polar decomposition) */
static int made_exact(const double *pose, double *T)
{
    double R[9];
    double S[9];
    double Q[9];
    int wrong = 0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            R[3 * i + j] = pose[4 * i + j];
        }
        T[4 * i + 3] = pose[4 * i + 3];
        wrong = pose[12 + i] == 0.0 && fabs(T[4 * i + 3]) <= LARGEST ? wrong : 1;
    }
    wrong = pose[15] == 1.0 ? wrong : 1;
    for (int step = 0; step < 2; step++) {
        product_of_transposed(R, R, S);
        for (int i = 0; i < 9; i++) {
            const double off = i % 4 == 0 ? fabs(S[i] - 1.0) : fabs(S[i]);
            wrong = step == 1 || off <= ORTHONORMAL ? wrong : 1;
        }
        product(R, S, Q);
        for (int i = 0; i < 9; i++) {
            R[i] = 1.5 * R[i] - 0.5 * Q[i];
        }
    }
    const double across = R[0] * (R[4] * R[8] - R[5] * R[7]) - R[1] * (R[3] * R[8] - R[5] * R[6]);
    wrong = across + R[2] * (R[3] * R[7] - R[4] * R[6]) > 0.0 ? wrong : 1;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            T[4 * i + j] = R[3 * i + j];
        }
    }
    return wrong;
}

/* sine and cosine of x by one reduction: the bits of own_sin and own_cos */
static void sine_and_cosine(double x, double *out)
{
    const double scaled = x * PER_HALF_TURN;
    const double turns = (scaled + MAGIC) - MAGIC;
    const double pairs = (turns * 0.5 + MAGIC) - MAGIC;
    const double odd = turns - 2.0 * pairs;
    const double sign = 1.0 - 2.0 * (odd * odd);
    const double r = (x - turns * PI_PARTS[0]) - (turns * PI_PARTS[1] + turns * PI_PARTS[2]);
    const double square = r * r;
    double total = COSINE[0];
    for (int i = 1; i < COSINE_TERMS; i++) {
        total = total * square + COSINE[i];
    }
    out[1] = sign * ((1.0 - 0.5 * square) + square * square * total);
    total = SINE[0];
    for (int i = 1; i < SINE_TERMS; i++) {
        total = total * square + SINE[i];
    }
    out[0] = sign * r + sign * r * square * total;
}

/* the largest entry of FK(q) - T for branch b; B keeps the frames of the branch before, of joints that have not moved */
static double residual(const double *T, const double *q, int b, double *B)
{
    double turn[2];
    const int at = JOINTS * b;
    int moved_from = 0;
    while (b > 0 && moved_from < JOINTS && q[at + moved_from] == q[at + moved_from - JOINTS]) {
        moved_from++;
    }
    for (int j = 0; j < JOINTS; j++) {
        if (j >= moved_from) {
            sine_and_cosine(q[at + j], turn);
            const double c = turn[1];
            const double s = turn[0];
            for (int i = 0; i < 3; i++) {
                const double x = c * B[12 * j + 4 * i] + s * B[12 * j + 4 * i + 1];
                const double y = c * B[12 * j + 4 * i + 1] - s * B[12 * j + 4 * i];
                const double z = B[12 * j + 4 * i + 2];
                for (int k = 0; k < 4; k++) {
                    B[12 * j + 12 + 4 * i + k] =
                        x * FRAMES[12 * j + 12 + k] + y * FRAMES[12 * j + 16 + k] + z * FRAMES[12 * j + 20 + k];
                }
                B[12 * j + 15 + 4 * i] += B[12 * j + 4 * i + 3];
            }
        }
    }
    double largest = 0.0;
    for (int i = 0; i < 12; i++) {
        largest = larger(fabs(B[12 * JOINTS + i] - T[i]), largest);
    }
    return largest;
}

/* the residuals of the branches, of the pose behind TARGET */
static void residuals(double *out)
{
    double T[12];
    double B[96];
    for (int i = 0; i < 12; i++) {
        T[i] = out[TARGET + i];
        B[i] = FRAMES[i];
    }
    for (int b = 0; b < 8; b++) {
        if (out[JOINTS * b] <= UNLIMITED) {
            out[RESIDUAL + b] = residual(T, out, b, B);
        }
    }
}

/* whole turns of each joint of branch b that are inside its limits: the first, and how many; gives their product */
static double copies(double *out, int b)
{
    double total = 1.0;
    for (int i = 0; i < JOINTS; i++) {
        const int at = JOINTS * b + i;
        const double q = out[at];
        double first = 0.0;
        double many = 1.0;
        if (b > 0 && q == out[at - JOINTS] && out[LEFT_OUT] == 0.0) {
            first = out[FIRST + at - JOINTS];
            many = out[MANY + at - JOINTS];
        } else if (LIMITED[i] > 0.0) {
            const double below = (q - ALLOWED[2 * i]) / TURN;
            const double above = (ALLOWED[2 * i + 1] - q) / TURN;
            const double down = floor(below);
            const double up = floor(above);
            if (fabs(below - down - 0.5) > CERTAIN_TURN || fabs(above - up - 0.5) > CERTAIN_TURN) {
                out[SPECIAL] = 1.0;
            }
            first = -down;
            many = up + down + 1.0;
        }
        out[FIRST + at] = first;
        out[MANY + at] = many;
        total = many < 1.0 ? 0.0 : total * many;
    }
    return total;
}

/* notes the branch that is least outside the limits, by its joint that is furthest */
static void outside(double *out, int b)
{
    double margin = smaller(UP[0] - out[JOINTS * b], out[JOINTS * b] - LOW[0]);
    double joint = 0.0;
    for (int i = 1; i < JOINTS; i++) {
        const double room = smaller(UP[i] - out[JOINTS * b + i], out[JOINTS * b + i] - LOW[i]);
        if (room < margin) {
            margin = room;
            joint = i;
        }
    }
    if (out[OUTSIDE] == 0.0 || margin > out[MARGIN]) {
        out[MARGIN] = margin;
        out[JOINT] = joint;
    }
    out[OUTSIDE] += 1.0;
}

/* whether branches a and b agree but for whole turns */
static int is_same(const double *q, int a, int b)
{
    int i = 0;
    while (i < JOINTS) {
        const double off = fabs(q[JOINTS * a + i] - q[JOINTS * b + i]);
        if (off > SAME && fabs(off - TURN) > SAME) {
            return 0;
        }
        i++;
    }
    return 1;
}

/* the branches in out[0] and after: copies inside the limits, how many are inside and outside; and where a residual may
   be too large, the residuals, which otherwise are found with the rows */
static void judged(const double *T, double *out)
{
    for (int i = WORST; i < SIZE; i++) {
        out[i] = 0.0;
    }
    for (int i = 0; i < 12; i++) {
        out[TARGET + i] = T[i];
    }
    for (int b = 0; b < 8; b++) {
        out[COPIES + b] = 0.0;
        out[RESIDUAL + b] = 0.0;
        if (out[JOINTS * b] <= UNLIMITED) {
            const double total = copies(out, b);
            if (total > MOST_COPIES) {
                out[LEFT_OUT] += total - 1.0;
                for (int i = 0; i < JOINTS; i++) {
                    out[FIRST + JOINTS * b + i] = 0.0;
                    out[MANY + JOINTS * b + i] = 1.0;
                }
            }
            out[COPIES + b] = total > MOST_COPIES ? 1.0 : total;
            out[INSIDE] += out[COPIES + b];
            if (total < 1.0) {
                outside(out, b);
            }
            for (int a = 0; a < b; a++) {
                const double off = fabs(out[JOINTS * a] - out[JOINTS * b]);
                if ((off <= SAME || fabs(off - TURN) <= SAME) && is_same(out, a, b) == 1) {
                    out[SPECIAL] = 1.0;
                }
            }
        } else {
            for (int i = 0; i < JOINTS; i++) {
                out[FIRST + JOINTS * b + i] = 0.0;
                out[MANY + JOINTS * b + i] = 0.0;
            }
        }
    }
    if (IS_CHECKED == 1) {
        residuals(out);
        for (int b = 0; b < 8; b++) {
            out[WORST] = larger(out[RESIDUAL + b], out[WORST]);
        }
    }
}
