/* 16 numbers: last row 0 0 0 1, R^T R = 1, det R > 0, all finite */
static int is_pose(const double *T, int at)
{
    if (!(T[at + 12] == 0.0 && T[at + 13] == 0.0 && T[at + 14] == 0.0 && T[at + 15] == 1.0)) {
        return 0;
    }
    for (int i = 0; i < 3; i++) {
        if (!(fabs(T[at + 4 * i + 3]) < LARGEST)) {
            return 0;
        }
        for (int j = 0; j < i + 1; j++) {
            const double dot = T[at + i] * T[at + j] + T[at + 4 + i] * T[at + 4 + j] + T[at + 8 + i] * T[at + 8 + j];
            if (!(fabs(dot - (i == j ? 1.0 : 0.0)) <= ORTHONORMAL)) {
                return 0;
            }
        }
    }
    const double first = T[at + 5] * T[at + 10] - T[at + 6] * T[at + 9];
    const double second = T[at + 6] * T[at + 8] - T[at + 4] * T[at + 10];
    const double third = T[at + 4] * T[at + 9] - T[at + 5] * T[at + 8];
    return T[at] * first + T[at + 1] * second + T[at + 2] * third > 0.0;
}

/* joint positions whose sines are exact */
static int is_finite(const double *q, int at)
{
    for (int i = 0; i < N; i++) {
        if (!(fabs(q[at + i]) < FAR)) {
            return 0;
        }
    }
    return 1;
}

/* a pose to a lane, its rotation made exact by a Newton step of the polar decomposition: R (3 - R^T R) / 2 */
static void take_pose(const double *T, int at, double *b, int lane)
{
    for (int j = 0; j < 3; j++) {
        for (int i = 0; i < 3; i++) {
            double total = 1.5 * T[at + 4 * i + j];
            for (int k = 0; k < 3; k++) {
                const double dot =
                    T[at + j] * T[at + k] + T[at + 4 + j] * T[at + 4 + k] + T[at + 8 + j] * T[at + 8 + k];
                total -= 0.5 * T[at + 4 * i + k] * dot;
            }
            b[(TARGET + 4 * i + j) * W + lane] = total;
        }
    }
    for (int i = 0; i < 3; i++) {
        b[(TARGET + 4 * i + 3) * W + lane] = T[at + 4 * i + 3];
    }
}

/* the next q of a lane is that of its start: q0 where it is given, then row by row of the table */
static void begin(double *b, int lane, const double *s, const double *q0, int at, int given, int start)
{
    b[(STATE + START) * W + lane] = start;
    b[(STATE + STEPS) * W + lane] = 0.0;
    b[REPAIR * W + lane] = 0.0;
    const int row = TABLE + (start - (given ? 1 : 0)) * N;
    for (int i = 0; i < N; i++) {
        b[(NEXT + i) * W + lane] = given && start == 0 ? q0[at + i] : s[row + i];
    }
}

/* moves the angles of q by whole turns to the reference and into the limits; the largest excess */
static double settle(double *b, int lane, const double *s)
{
    double excess = -LARGEST;
    for (int i = 0; i < N; i++) {
        const double low = s[LOWER + i];
        const double up = s[UPPER + i];
        double q = b[i * W + lane];
        if (s[TURNS] != 0.0 && s[TURNING + i] != 0.0) {
            q -= TURN * ((q - b[(NEAR + i) * W + lane]) / TURN + MAGIC - MAGIC);
            if (q > up && q - TURN >= low) {
                q -= TURN;
            } else if (q < low && q + TURN <= up) {
                q += TURN;
            }
            b[i * W + lane] = q;
        }
        excess = larger(excess, larger(low - q, q - up));
    }
    return excess;
}

/* keeps a miss if it is the nearest of its pose: outside the limits by least, else of the smallest E */
static void remember(double *b, int lane, double code, double miss)
{
    const double known = b[(STATE + CODE) * W + lane];
    if (code > known || (code == known && !(miss < b[(STATE + MISS) * W + lane]))) {
        return;
    }
    b[(STATE + CODE) * W + lane] = code;
    b[(STATE + MISS) * W + lane] = miss;
    for (int i = 0; i < 3; i++) {
        b[(STATE + PLACE + i) * W + lane] = b[(MEASURES + i) * W + lane];
    }
    for (int i = 0; i < N; i++) {
        b[(MISSED + i) * W + lane] = b[i * W + lane];
    }
}

/* the next q of a lane is the one from row `first` on, moved to the limits that it passes */
static void hold(double *b, int lane, const double *s, int first)
{
    for (int i = 0; i < N; i++) {
        b[(NEXT + i) * W + lane] = smaller(larger(b[(first + i) * W + lane], s[LOWER + i]), s[UPPER + i]);
    }
}

/* the pose is reached outside the limits: begin to pull, or hold, or give this start up; as `judge` */
static int repair(double *b, int lane, const double *s, double excess)
{
    if (excess > (s[REDUNDANT] != 0.0 ? LARGE : SMALL)) {
        return 2;
    }
    b[REPAIR * W + lane] = s[REDUNDANT] != 0.0 && excess > SMALL ? PULL : HOLD;
    b[(STATE + STEPS) * W + lane] = 0.0;
    hold(b, lane, s, 0);
    return 0;
}

/* after a step of a repair; as `judge` */
static int judge_repair(double *b, int lane, const double *s, double steps, double half)
{
    if (!(half < LARGE)) {
        return 2;
    }
    double mode = b[REPAIR * W + lane];
    if (steps >= REPAIR_STEPS) {
        if (mode == HOLD || b[(STATE + START) * W + lane] < HOLD_FROM) {
            return 2;
        }
        mode = HOLD;
        b[REPAIR * W + lane] = HOLD;
        b[(STATE + STEPS) * W + lane] = 0.0;
    }
    if (mode == HOLD) {
        hold(b, lane, s, NEXT);
    }
    return 0;
}

/* after a step: 0 go on, 1 solved, 2 this start has failed */
static int judge(double *b, int lane, const double *s)
{
    const double place = b[MEASURES * W + lane];
    const double sine = b[(MEASURES + 1) * W + lane];
    const double cosine = b[(MEASURES + 2) * W + lane];
    const double steps = b[(STATE + STEPS) * W + lane] + 1.0;
    const double mode = b[REPAIR * W + lane];
    const double half = place / 2.0 + 1.0 - cosine;
    b[(STATE + STEPS) * W + lane] = steps;
    b[(STATE + ALL) * W + lane] += 1.0;
    if (place <= SQUARE && sine <= SQUARE && cosine > 0.0 && (mode != PULL || b[(MEASURES + 3) * W + lane] == 0.0)) {
        const double excess = settle(b, lane, s);
        if (excess <= 0.0) {
            return 1;
        }
        remember(b, lane, OUTSIDE, excess);
        if (mode == 0.0) {
            return repair(b, lane, s, excess);
        }
    }
    if (mode != 0.0) {
        return judge_repair(b, lane, s, steps, half);
    }
    double most = half > CLOSE ? FEW : MANY;
    if (half < CLOSEST && b[(STATE + START) * W + lane] < PATIENT) {
        most = MOST;
    }
    if (half < LARGE && steps < most) {
        return 0;
    }
    remember(b, lane, NOT_REACHED, half);
    return 2;
}

/* a pose to a lane: its target, the position that its solution shall be near to, an empty record */
static void open_pose(double *b, int lane, const double *s, const double *T, int t, const double *q0, int at, int given)
{
    take_pose(T, t, b, lane);
    b[(STATE + ALL) * W + lane] = 0.0;
    b[(STATE + CODE) * W + lane] = INVALID;
    for (int i = 0; i < N; i++) {
        b[(NEAR + i) * W + lane] =
            given ? smaller(larger(q0[at + i], s[LOWER + i]), s[UPPER + i]) : s[MIDDLE + i];
    }
}

/* the row of a pose: the q of the lane, or its nearest miss */
static void write_row(const double *b, int lane, double *out, int at, int solved)
{
    const int q = solved ? 0 : MISSED;
    const int measures = solved ? MEASURES : STATE + PLACE;
    for (int i = 0; i < N; i++) {
        out[at + i] = b[(q + i) * W + lane];
    }
    out[at + N] = solved ? FOUND : b[(STATE + CODE) * W + lane];
    for (int i = 0; i < 3; i++) {
        out[at + N + 1 + i] = b[(measures + i) * W + lane];
    }
    out[at + N + 4] = b[(STATE + START) * W + lane];
    out[at + N + 5] = b[(STATE + ALL) * W + lane];
}

/* the first start of the next pose goes to a lane; the number of the pose behind it */
static int next_pose(double *b, int lane, const double *s, const double *T, int T_step, const double *q0, int q0_step,
                     double *out, int waiting, int stop)
{
    const int given = q0_step >= 0;
    int p = waiting;
    b[STATE * W + lane] = -1.0;
    while (p < stop) {
        if (is_pose(T, p * T_step) && (!given || is_finite(q0, p * q0_step))) {
            b[STATE * W + lane] = p;
            open_pose(b, lane, s, T, p * T_step, q0, p * q0_step, given);
            begin(b, lane, s, q0, p * q0_step, given, 0);
            return p + 1;
        }
        for (int i = 0; i < ROW; i++) {
            out[p * ROW + i] = i == N ? INVALID : 0.0;
        }
        p += 1;
    }
    return stop;
}

/* the row of a pose without a solution: the nearest of the lanes' misses */
static void write_nearest_miss(const double *b, double *out, int at)
{
    int nearest = 0;
    for (int lane = 1; lane < W; lane++) {
        const double code = b[(STATE + CODE) * W + lane];
        const double known = b[(STATE + CODE) * W + nearest];
        if (code < known ||
            (code == known && b[(STATE + MISS) * W + lane] < b[(STATE + MISS) * W + nearest])) {
            nearest = lane;
        }
    }
    write_row(b, nearest, out, at, 0);
}

/* whether a lane has a pose; the next q of all becomes q */
static int is_working(double *b)
{
    for (int i = 0; i < N * W; i++) {
        b[i] = b[NEXT * W + i];
    }
    for (int lane = 0; lane < W; lane++) {
        if (b[STATE * W + lane] >= 0.0) {
            return 1;
        }
    }
    return 0;
}

/* each lane has its own pose; a lane whose pose is done takes the next one */
static int many_poses(const double *T, int T_step, const double *q0, int q0_step, const double *s, double *out,
                      double *b, int start, int stop)
{
    int waiting = start;
    for (int lane = 0; lane < W; lane++) {
        waiting = next_pose(b, lane, s, T, T_step, q0, q0_step, out, waiting, stop);
    }
    while (is_working(b)) {
        body(b);
        for (int lane = 0; lane < W; lane++) {
            if (b[STATE * W + lane] >= 0.0) {
                const int p = (int)b[STATE * W + lane];
                const int own = (int)b[(STATE + START) * W + lane];
                const int verdict = judge(b, lane, s);
                if (verdict == 2 && own + 1 < s[STARTS]) {
                    begin(b, lane, s, q0, p * q0_step, q0_step >= 0, own + 1);
                } else if (verdict != 0) {
                    write_row(b, lane, out, p * ROW, verdict == 1);
                    waiting = next_pose(b, lane, s, T, T_step, q0, q0_step, out, waiting, stop);
                }
            }
        }
    }
    return 0;
}

/* all lanes have one pose, each its own starts; the first start in order that ends in a solution wins */
static int one_pose(const double *T, int T_step, const double *q0, int q0_step, const double *s, double *out, double *b,
                    int p, int stop)
{
    const int starts = (int)s[STARTS];
    int best = starts;
    int opened = 0;
    for (int lane = 0; lane < W; lane++) {
        b[STATE * W + lane] = -1.0;
        b[(STATE + CODE) * W + lane] = INVALID;
        if (lane < starts) {
            next_pose(b, lane, s, T, T_step, q0, q0_step, out, p, stop);
            if (b[STATE * W + lane] >= 0.0) {
                begin(b, lane, s, q0, p * q0_step, q0_step >= 0, lane);
            }
        }
    }
    while (is_working(b)) {
        body(b);
        opened = 1;
        for (int lane = 0; lane < W; lane++) {
            if (b[STATE * W + lane] >= 0.0) {
                const int own = (int)b[(STATE + START) * W + lane];
                const int verdict = judge(b, lane, s);
                if (verdict == 1 && own < best) {
                    write_row(b, lane, out, p * ROW, 1);
                    best = own;
                }
                if (verdict == 2 && own + W < best) {
                    begin(b, lane, s, q0, p * q0_step, q0_step >= 0, own + W);
                } else if (verdict != 0 || own > best) {
                    b[STATE * W + lane] = -1.0;
                }
            }
        }
    }
    if (opened && best == starts) {
        write_nearest_miss(b, out, p * ROW);
    }
    return 0;
}

int search(const double *T, int T_step, const double *q0, int q0_step, const double *s, int s_size, double *out,
           double *b, int start, int stop)
{
    for (int i = 0; i < ROOM; i++) {
        b[i] = 0.0;
    }
    if (stop - start > 1) {
        return many_poses(T, T_step, q0, q0_step, s, out, b, start, stop);
    }
    return one_pose(T, T_step, q0, q0_step, s, out, b, start, stop);
}
