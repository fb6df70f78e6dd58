/* where a cos + b sin + c = 0, into cuts[at] and cuts[at + 1]; -pi without a root; a touch counts */
static void roots(double a, double b, double c, double *cuts, int at)
{
    const double size = sqrt(a * a + b * b);
    const double level = size > ALIGNED ? -c / size : 2.0;
    cuts[at] = -HALF_TURN;
    cuts[at + 1] = -HALF_TURN;
    if (fabs(level) <= 1.0 + TOUCH) {
        const double middle = atan2(b, a);
        const double spread = acos(larger(smaller(level, 1.0), -1.0));
        cuts[at] = -wrap(spread - middle);
        cuts[at + 1] = -wrap(-spread - middle);
    }
}

/* arm angles at which a roll reaches a bound of its range, into four places of cuts */
static void roll_cuts(const double *G, int x, int y, double centre, double reach, double *cuts, int at)
{
    for (int i = 0; i < 4; i++) {
        cuts[at + i] = -HALF_TURN;
    }
    if (reach < HALF_TURN) {
        for (int i = 0; i < 2; i++) {
            const double bound = i == 0 ? centre - reach : centre + reach;
            const double c = cos(bound);
            const double s = sin(bound);
            roots(G[y] * c - G[x] * s, G[y + 1] * c - G[x + 1] * s, G[y + 2] * c - G[x + 2] * s, cuts, at + 2 * i);
        }
    }
}

/* arm angles at which a tilt reaches a bound of its range */
static void tilt_cuts(const double *G, int z, double centre, double reach, double *cuts, int at)
{
    for (int i = 0; i < 4; i++) {
        cuts[at + i] = -HALF_TURN;
    }
    if (reach < HALF_TURN) {
        roots(G[z], G[z + 1], G[z + 2] - cos(centre - reach), cuts, at);
        roots(G[z], G[z + 1], G[z + 2] - cos(centre + reach), cuts, at + 2);
    }
}

/* arm angles at which the tilt of a ball passes 0 or half a turn */
static void alignment_cuts(const double *G, int z, double *cuts, int at)
{
    const double size = sqrt(G[z] * G[z] + G[z + 1] * G[z + 1]);
    const double top = atan2(G[z + 1], G[z]);
    cuts[at] = size > ALIGNED && G[z + 2] + size >= 1.0 - 1e-14 ? wrap(top) : -HALF_TURN;
    cuts[at + 1] = size > ALIGNED && G[z + 2] - size <= -1.0 + 1e-14 ? wrap(top + HALF_TURN) : -HALF_TURN;
}

/* |angle of (x, y) - centre|, the centre by its cosine and sine */
static double away(double x, double y, double c, double s)
{
    return atan2(fabs(y * c - x * s), x * c + y * s);
}

/* those of `ball_margins` where the ball's rolls turn about one line: both are as far from their middles */
static void aligned_margins(const double *G, int at, const double *turn, double sign, int joint, double *m)
{
    for (int i = 0; i < ROW; i++) {
        const double c = turn[i];
        const double s = turn[ROW + i];
        const double tilt = m[2 * ROW + i];
        if (tilt < ALIGNED) {
            const double z = c * G[at + 12] + s * G[at + 13] + G[at + 14];
            const double ya = c * G[at + 15] + s * G[at + 16] + G[at + 17];
            const double xa = c * G[at + 18] + s * G[at + 19] + G[at + 20];
            const double both = MIDDLE[joint] + (z > 0.0 ? MIDDLE[joint + 2] : -MIDDLE[joint + 2]);
            const double roll = fabs(wrap(atan2(ya, xa) - both)) / 2.0;
            const double off = away(z, sign * tilt, CENTRE_COSINE[joint + 1], CENTRE_SINE[joint + 1]);
            const double middle = HALF[joint + 1] - off;
            m[i] = smaller(smaller(HALF[joint] - roll, HALF[joint + 2] - roll), middle);
            m[ROW + i] = HALF[joint] - roll + middle + (HALF[joint + 2] - roll);
        }
    }
}

/* margins of a ball's joints at ROW arm angles given by cosines, then sines: into m the smallest, the sums, the tilts'
   sines; G from `at` on holds its seven forms */
static void ball_margins(const double *G, int at, const double *turn, double sign, int joint, double *m)
{
    double row[48];
    for (int i = 0; i < ROW; i++) {
        const double c = turn[i];
        const double s = turn[ROW + i];
        const double x = c * G[at] + s * G[at + 1] + G[at + 2];
        const double y = c * G[at + 3] + s * G[at + 4] + G[at + 5];
        const double x2 = c * G[at + 6] + s * G[at + 7] + G[at + 8];
        const double y2 = c * G[at + 9] + s * G[at + 10] + G[at + 11];
        const double z = c * G[at + 12] + s * G[at + 13] + G[at + 14];
        const double tilt = sqrt(x * x + y * y);
        const double first = HALF[joint] - away(x, y, CENTRE_COSINE[joint], CENTRE_SINE[joint]);
        const double second = HALF[joint + 2] - away(x2, y2, CENTRE_COSINE[joint + 2], CENTRE_SINE[joint + 2]);
        const double middle = HALF[joint + 1] - away(z, sign * tilt, CENTRE_COSINE[joint + 1], CENTRE_SINE[joint + 1]);
        row[i] = smaller(smaller(first, second), middle);
        row[ROW + i] = first + middle + second;
        row[2 * ROW + i] = tilt;
    }
    double flattest = 1.0;
    for (int i = 0; i < 3 * ROW; i++) {
        m[i] = row[i];
    }
    for (int i = 0; i < ROW; i++) {
        flattest = smaller(flattest, row[2 * ROW + i]);
    }
    if (flattest < ALIGNED) {
        aligned_margins(G, at, turn, sign, joint, m);
    }
}

/* of a branch at ROW arm angles: the smallest margin of the joints that move with it, and a share of the sum of all */
static void moving_margins(const double *G, const double *psi, double shoulder, double wrist, double tie, double *out)
{
    double turn[32];
    double first[48];
    double last[48];
    for (int i = 0; i < ROW; i++) {
        turn[i] = cos(psi[i]);
        turn[ROW + i] = sin(psi[i]);
    }
    ball_margins(G, 0, turn, shoulder, 0, first);
    ball_margins(G, 21, turn, wrist, 4, last);
    for (int i = 0; i < ROW; i++) {
        out[i] = smaller(first[i], last[i]) + tie * (first[ROW + i] + last[ROW + i]);
    }
}

/* the seven forms of a branch's ball from its matrix, and the 14 cuts of its joints */
static void ball_cuts(const double *F, int at, double sign, int joint, double margin, double *G, double *cuts, int ball)
{
    const int g = 21 * ball;
    const int cut = 1 + 12 * ball;
    double moving = 0.0;
    double side = 0.0;
    for (int k = 0; k < 3; k++) {
        G[g + k] = sign * F[at + 9 * k + 2];
        G[g + 3 + k] = sign * F[at + 9 * k + 5];
        G[g + 6 + k] = -sign * F[at + 9 * k + 6];
        G[g + 9 + k] = sign * F[at + 9 * k + 7];
        G[g + 12 + k] = F[at + 9 * k + 8];
        G[g + 15 + k] = -F[at + 9 * k + 1];
        G[g + 18 + k] = F[at + 9 * k + 4];
        moving += fabs(G[g + k]) + fabs(G[g + 3 + k]);
        side += G[g + 12 + k];
    }
    if (moving < ALIGNED) {
        const double centre = MIDDLE[joint] + (side > 0.0 ? MIDDLE[joint + 2] : -MIDDLE[joint + 2]);
        roll_cuts(G, g + 18, g + 15, centre, 2.0 * (HALF[joint] - margin), cuts, cut);
        roll_cuts(G, g + 18, g + 15, centre, 2.0 * (HALF[joint + 2] - margin), cuts, cut + 4);
    } else {
        roll_cuts(G, g, g + 3, MIDDLE[joint], HALF[joint] - margin, cuts, cut);
        roll_cuts(G, g + 6, g + 9, MIDDLE[joint + 2], HALF[joint + 2] - margin, cuts, cut + 4);
    }
    tilt_cuts(G, g + 12, MIDDLE[joint + 1] + OFFSETS[joint], HALF[joint + 1] - margin, cuts, cut + 8);
    alignment_cuts(G, g + 12, cuts, 25 + 2 * ball);
}

/* arm angles by rising value, with a mark at those where a ball aligns */
static void sort_cuts(double *cuts, double *hard)
{
    for (int i = 0; i < 29; i++) {
        const double x = cuts[i];
        const double mark = i >= 25 && x > -HALF_TURN ? 1.0 : 0.0;
        int j = i;
        while (j > 0 && cuts[j - 1] > x) {
            cuts[j] = cuts[j - 1];
            hard[j] = hard[j - 1];
            j--;
        }
        cuts[j] = x;
        hard[j] = mark;
    }
}

/* the pieces that are inside, joined round the circle except at alignments: pairs into out[at]; returns how many */
static int joined(const double *cuts, const double *hard, const double *inside, double *out, int at)
{
    int count = 0;
    int opened = 0;
    double wrapped = 0.0;
    for (int i = 0; i < 29; i++) {
        const int before = i == 0 ? 28 : i - 1;
        const int after = i == 28 ? 0 : i + 1;
        if (inside[i] > 0.0 && (!(inside[before] > 0.0) || hard[i] > 0.0) && count < MOST) {
            out[at + 2 * count] = cuts[i];
            count++;
            opened = 1;
        }
        if (inside[i] > 0.0 && (!(inside[after] > 0.0) || hard[after] > 0.0)) {
            const double end = i == 28 ? HALF_TURN : cuts[i + 1];
            if (opened == 1) {
                out[at + 2 * count - 1] = end;
                opened = 0;
            } else {
                wrapped = end + TURN;
            }
        }
    }
    if (opened == 1) {
        out[at + 2 * count - 1] = wrapped;
    }
    if (count == 0 && inside[0] > 0.0) {
        out[at] = -HALF_TURN;
        out[at + 1] = HALF_TURN;
        count = 1;
    }
    return count;
}

/* intervals of one branch with the forms of its elbow; returns how many */
static int branch_intervals(const double *F, double shoulder, double wrist, double margin, double *out, int at)
{
    double G[42];
    double cuts[29];
    double hard[29];
    double inside[32];
    double psi[16];
    double margins[16];
    const double elbow = HALF[3] - fabs(wrap(F[54] - MIDDLE[3]));
    if (!(elbow >= margin - TOUCH)) {
        return 0;
    }
    cuts[0] = -HALF_TURN;
    ball_cuts(F, 0, shoulder, 0, margin, G, cuts, 0);
    ball_cuts(F, 27, wrist, 4, margin, G, cuts, 1);
    sort_cuts(cuts, hard);
    for (int from = 0; from < 32; from += ROW) {
        for (int i = 0; i < ROW; i++) {
            const int k = from + i < 29 ? from + i : 28;
            psi[i] = (cuts[k] + (k == 28 ? HALF_TURN : cuts[k + 1])) / 2.0;
        }
        moving_margins(G, psi, shoulder, wrist, 0.0, margins);
        for (int i = 0; i < ROW; i++) {
            inside[from + i] = margins[i] >= margin - TOUCH ? 1.0 : 0.0;
        }
    }
    return joined(cuts, hard, inside, out, at);
}

double inverse_kinematics_intervals(const double pose[16], double margin, double out[256], int counts[8])
{
    double F[55];
    double excess = 0.0;
    for (int e = 0; e < 2; e++) {
        excess = forms(pose, e == 0 ? 1.0 : -1.0, F);
        for (int b = 0; b < 4; b++) {
            const int place = b + 2 * (e + (b < 2 ? 0 : 1));
            counts[place] = 0;
            if (excess <= 0.0) {
                counts[place] =
                    branch_intervals(F, b < 2 ? 1.0 : -1.0, b % 2 == 0 ? 1.0 : -1.0, margin, out, 32 * place);
            }
        }
    }
    return excess;
}

/* the arm angle of n intervals from out[0] on that is nearest to psi */
static double nearest_arm_angle(const double *intervals, int n, double psi)
{
    double best = psi;
    double least = UNLIMITED;
    for (int i = 0; i < n; i++) {
        const double half = (intervals[2 * i + 1] - intervals[2 * i]) / 2.0;
        const double middle = intervals[2 * i] + half;
        const double from = wrap(psi - middle);
        const double distance = fabs(from) - half;
        if (distance < least) {
            least = distance;
            best = middle + larger(smaller(from, half), -half);
        }
    }
    return best;
}

int inverse_kinematics_near(const double pose[16], double arm_angle, const double q_near[7], double out[7])
{
    double F[55];
    double intervals[32];
    double q[7];
    int found = 3;
    double least = UNLIMITED;
    for (int e = 0; e < 2; e++) {
        if (!(forms(pose, e == 0 ? 1.0 : -1.0, F) <= 0.0)) {
            return 3;
        }
        found = e == 0 ? 2 : found;
        for (int b = 0; b < 4; b++) {
            const double shoulder = b < 2 ? 1.0 : -1.0;
            const double wrist = b % 2 == 0 ? 1.0 : -1.0;
            branch(F, cos(arm_angle), sin(arm_angle), shoulder, wrist, q, 0);
            int status = 0;
            if (!(smallest_margin(q, 0) >= -TOUCH)) {
                const int n = branch_intervals(F, shoulder, wrist, 0.0, intervals, 0);
                const double psi = nearest_arm_angle(intervals, n, arm_angle);
                branch(F, cos(psi), sin(psi), shoulder, wrist, q, 0);
                status = n > 0 ? 1 : 2;
            }
            double distance = 0.0;
            for (int i = 0; i < 7; i++) {
                q[i] = nearest_turn(q[i], q_near[i], i);
                distance += (q[i] - q_near[i]) * (q[i] - q_near[i]);
            }
            if (status < 2 && distance < least) {
                least = distance;
                found = status;
                for (int i = 0; i < 7; i++) {
                    out[i] = q[i];
                }
            }
        }
    }
    return found;
}
