/* the arm angle near psi, within `width`, at which the smallest margin is largest */
static double climbed(const double *G, double psi, double width, double shoulder, double wrist)
{
    double near[16];
    double margins[16];
    double best = psi;
    double reach = width;
    for (int zoom = 0; zoom < ZOOMS; zoom++) {
        double most = -UNLIMITED;
        for (int i = 0; i < ROW; i++) {
            const double share = i - HALF_POINTS;
            near[i] = best + reach * (share / HALF_POINTS);
        }
        moving_margins(G, near, shoulder, wrist, TIE, margins);
        for (int i = 0; i < POINTS; i++) {
            if (margins[i] > most) {
                most = margins[i];
                best = near[i];
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
    double near[16];
    double margins[16];
    double most = -UNLIMITED;
    double psi = 0.0;
    const double step = TURN / GRID;
    ball_cuts(F, 0, shoulder, 0, 0.0, G, cuts, 0);
    ball_cuts(F, 27, wrist, 4, 0.0, G, cuts, 1);
    for (int from = 0; from < GRID; from += ROW) {
        for (int i = 0; i < ROW; i++) {
            near[i] = step * (from + i) - HALF_TURN;
        }
        moving_margins(G, near, shoulder, wrist, TIE, margins);
        for (int i = 0; i < ROW; i++) {
            if (margins[i] > most) {
                most = margins[i];
                psi = near[i];
            }
        }
    }
    psi = climbed(G, psi, step, shoulder, wrist);
    int round = 0;
    while (round < ROUNDS) {
        for (int i = 0; i < ROW; i++) {
            near[i] = psi;
        }
        moving_margins(G, near, shoulder, wrist, 0.0, margins);
        const double elbow = HALF[3] - fabs(wrap(F[54] - MIDDLE[3]));
        const double level = smaller(elbow, margins[0]) + CERTAIN;
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
int solutions(const double given[18], double out[488])
{
    double T[12];
    double F[55];
    double excess = 0.0;
    if (made_exact(given, T) == 1) {
        return 1;
    }
    if (given[16] == given[16]) {
        excess = inverse_kinematics(T, given[16], out);
    }
    for (int i = 0; i < 16; i++) {
        out[POSE + i] = given[i];
    }
    for (int b = 0; b < 8; b++) {
        out[ARM_ANGLE + b] = given[16] == given[16] ? given[16] : 0.0;
        out[COUNTS + b] = 0.0;
    }
    if (!(given[16] == given[16]) || given[17] == given[17]) {
        for (int e = 0; e < 2; e++) {
            excess = forms(T, e == 0 ? 1.0 : -1.0, F);
            for (int b = 0; b < 4; b++) {
                const int place = b + 2 * (e + (b < 2 ? 0 : 1));
                const double shoulder = b < 2 ? 1.0 : -1.0;
                const double wrist = b % 2 == 0 ? 1.0 : -1.0;
                if (!(excess <= 0.0)) {
                    out[7 * place] = (double)NAN;
                } else if (given[17] == given[17]) {
                    out[COUNTS + place] = branch_intervals(F, shoulder, wrist, given[17], out, PAIRS + 32 * place);
                }
                if (excess <= 0.0 && !(given[16] == given[16])) {
                    const double psi = best_arm_angle(F, shoulder, wrist);
                    out[ARM_ANGLE + place] = psi;
                    branch(F, cos(psi), sin(psi), shoulder, wrist, out, 7 * place);
                }
            }
        }
    }
    judged(T, out);
    out[LEAST] = excess;
    return 0;
}
