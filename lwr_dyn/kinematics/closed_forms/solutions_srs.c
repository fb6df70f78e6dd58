/* of a branch at an arm angle: the smallest margin of the joints that move with it, and a little of the sum of all */
static double moving_margin(const double *G, double psi, double shoulder, double wrist)
{
    const double c = cos(psi);
    const double s = sin(psi);
    double first[2];
    double last[2];
    ball_margins(G, 0, c, s, shoulder, 0, first);
    ball_margins(G, 21, c, s, wrist, 4, last);
    return smaller(first[0], last[0]) + TIE * (first[1] + last[1]);
}

/* the arm angle near psi, within `width`, at which the smallest margin is largest */
static double climbed(const double *G, double psi, double width, double shoulder, double wrist)
{
    double best = psi;
    double reach = width;
    for (int zoom = 0; zoom < ZOOMS; zoom++) {
        const double middle = best;
        double most = -UNLIMITED;
        for (int i = 0; i < POINTS; i++) {
            const double share = i - HALF_POINTS;
            const double near = middle + reach * (share / HALF_POINTS);
            const double margin = moving_margin(G, near, shoulder, wrist);
            if (margin > most) {
                most = margin;
                best = near;
            }
        }
        reach = reach * (1.2 / HALF_POINTS);
    }
    return best;
}

/* the arm angle of a branch with the largest margin over the whole circle, to `CERTAIN` */
static double best_arm_angle(const double *F, double shoulder, double wrist)
{
    double G[42];
    double cuts[29];
    double pairs[32];
    double most = -UNLIMITED;
    double psi = 0.0;
    const double step = TURN / GRID;
    ball_cuts(F, 0, shoulder, 0, 0.0, G, cuts, 0);
    ball_cuts(F, 27, wrist, 4, 0.0, G, cuts, 1);
    for (int i = 0; i < GRID; i++) {
        const double near = step * i - HALF_TURN;
        const double margin = moving_margin(G, near, shoulder, wrist);
        if (margin > most) {
            most = margin;
            psi = near;
        }
    }
    psi = climbed(G, psi, step, shoulder, wrist);
    int round = 0;
    while (round < ROUNDS) {
        const double c = cos(psi);
        const double s = sin(psi);
        const double elbow = HALF[3] - fabs(wrap(F[54] - MIDDLE[3]));
        const double first = ball_margin(G, 0, c, s, shoulder, 0);
        const double last = ball_margin(G, 21, c, s, wrist, 4);
        const double level = smaller(elbow, smaller(first, last)) + CERTAIN;
        const int count = branch_intervals(F, shoulder, wrist, level, pairs, 0);
        double width = 0.0;
        double middle = 0.0;
        for (int i = 0; i < count; i++) {
            if (pairs[2 * i + 1] - pairs[2 * i] > width || i == 0) {
                width = pairs[2 * i + 1] - pairs[2 * i];
                middle = (pairs[2 * i + 1] + pairs[2 * i]) / 2.0;
            }
        }
        if (count == 0) {
            return wrap(psi);
        }
        psi = climbed(G, middle, width / 2.0, shoulder, wrist);
        round++;
    }
    return wrap(psi);
}

/* all solutions of a pose at given[16], or where that is NaN each branch at its best arm angle; what `judged` finds, the
   arm angles, and unless it is NaN the intervals of the arm angle in which all joints keep the margin given[17] */
int solutions(const double given[18], double out[472])
{
    double T[12];
    double F[55];
    double excess = 0.0;
    if (made_exact(given, T) == 1) {
        return 1;
    }
    for (int e = 0; e < 2; e++) {
        const double elbow = e == 0 ? 1.0 : -1.0;
        excess = forms(T, elbow, F);
        for (int b = 0; b < 4; b++) {
            const int place = b + 2 * (e + (b < 2 ? 0 : 1));
            const double shoulder = b < 2 ? 1.0 : -1.0;
            const double wrist = b % 2 == 0 ? 1.0 : -1.0;
            out[7 * place] = (double)NAN;
            out[ARM_ANGLE + place] = 0.0;
            out[COUNTS + place] = 0.0;
            if (excess <= 0.0) {
                const double psi = given[16] == given[16] ? given[16] : best_arm_angle(F, shoulder, wrist);
                out[ARM_ANGLE + place] = psi;
                branch(F, cos(psi), sin(psi), shoulder, wrist, out, 7 * place);
                if (given[17] == given[17]) {
                    out[COUNTS + place] = branch_intervals(F, shoulder, wrist, given[17], out, PAIRS + 32 * place);
                }
            }
        }
    }
    judged(T, out);
    out[LEAST] = excess;
    return 0;
}
