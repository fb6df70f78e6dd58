/* q4 of an aligned wrist: the middle of its range, moved only by what q6 cannot take inside its own range */
static double shared_roll(const double *M)
{
    const double direction = M[8] > 0.0 ? 1.0 : -1.0;
    const double q6 = wrap(atan2(M[3], M[4]) - direction * MIDDLE[3] - MIDDLE[5]);
    const double excess = larger(fabs(q6) - HALF[5], 0.0);
    return MIDDLE[3] + direction * (q6 < 0.0 ? -excess : excess);
}

/* q4, q5, q6 of the wrist's rotation: with its tilt from 0 to pi into q[place + 3] and after; with the other sign of it,
   both rolls half a turn on, into q[place + 9] and after */
static void wrist(const double *M, double *q, int place)
{
    const double sine = sqrt(M[2] * M[2] + M[5] * M[5]);
    const double roll = sine < ALIGNED ? shared_roll(M) : atan2(M[5], M[2]);
    const double turn = sine < ALIGNED ? 0.0 : HALF_TURN;
    const double c = cos(roll);
    const double s = sin(roll);
    const double tilt = atan2(sine, M[8]);
    const double second = atan2(c * M[3] - s * M[0], c * M[4] - s * M[1]);
    q[place + 3] = near_middle(roll, 3);
    q[place + 4] = near_middle(tilt - OFFSET, 4);
    q[place + 5] = near_middle(second, 5);
    q[place + 9] = near_middle(roll + turn, 3);
    q[place + 10] = near_middle(-tilt - OFFSET, 4);
    q[place + 11] = near_middle(second + turn, 5);
}

double inverse_kinematics(const double pose[16], double out[48])
{
    double w[3];
    double root[1];
    double target[9];
    double N[9];
    double A[9];
    double M[9];
    double least = UNLIMITED;
    wrist_centre(pose, w);
    wrist_rotation(pose, target);
    const double missing = shoulder_gap(w, root);
    const double along = w[2] - SHOULDER[0];
    for (int s = 0; s < 2; s++) {
        const double front = s == 0 ? FRONT * root[0] : -FRONT * root[0];
        const double ahead = front - SHOULDER[1];
        const double distance = sqrt(along * along + ahead * ahead);
        const double bend = elbow_bend(distance);
        const double short_of = reach_excess(distance);
        const double excess = short_of < missing ? missing : short_of;
        if (!(excess >= least)) {
            least = excess;
        }
        if (excess <= 0.0) {
            const double q1 = shoulder_angle(w, front);
            const double lean = atan2(ahead, along) - LEAN;
            const double inner = atan2(LENGTHS[1] * sin(bend), LENGTHS[0] + LENGTHS[1] * cos(bend));
            turned_back(target, q1, 0, 1, N);
            out[24 * s] = near_middle(q1, 0);
            for (int e = 0; e < 2; e++) {
                const int at = 24 * s + 12 * e;
                const double q2 = e == 0 ? lean - inner : lean + inner;
                const double q3 = e == 0 ? STRAIGHT + ELBOW_SIGN * bend : STRAIGHT - ELBOW_SIGN * bend;
                turned_back(N, q2 + ELBOW_SIGN * q3, 2, 0, A);
                product(BALL_TURNED, A, M);
                wrist(M, out, at);
                out[at] = out[24 * s];
                out[at + 1] = near_middle(q2, 1);
                out[at + 2] = near_middle(q3, 2);
                for (int i = at; i < at + 3; i++) {
                    out[i + 6] = out[i];
                }
            }
        } else {
            for (int i = 24 * s; i < 24 * s + 24; i++) {
                out[i] = (double)NAN;
            }
        }
    }
    return least;
}
