/* q4 of an aligned wrist: the middle of its range, moved only by what q6 cannot take inside its own range */
static double shared_roll(const double *M)
{
    const double direction = M[8] > 0.0 ? 1.0 : -1.0;
    const double q6 = wrap(atan2(M[3], M[4]) - direction * MIDDLE[3] - MIDDLE[5]);
    const double excess = larger(fabs(q6) - HALF[5], 0.0);
    return MIDDLE[3] + direction * (q6 < 0.0 ? -excess : excess);
}

/* q4, q5, q6 of the wrist's rotation with a sign of its tilt, into q[place + 3] and the two after it */
static void wrist(const double *M, double sign, double *q, int place)
{
    const double sine = sqrt(M[2] * M[2] + M[5] * M[5]);
    const double roll = sine < ALIGNED ? shared_roll(M) : atan2(sign * M[5], sign * M[2]);
    const double c = cos(roll);
    const double s = sin(roll);
    q[place + 3] = roll;
    q[place + 4] = atan2(sign * sine, M[8]) - OFFSET;
    q[place + 5] = atan2(c * M[3] - s * M[0], c * M[4] - s * M[1]);
}

/* two branches, one of each sign of the wrist's tilt, with the wrist centre at `along`, `out` of axis 2 */
static void elbow_branches(const double *target, double q1, double along, double out, double turn, double *q, int place)
{
    double A[9];
    double B[9];
    double M[9];
    const double q3 = STRAIGHT + ELBOW_SIGN * turn;
    const double inner = atan2(LENGTHS[1] * sin(turn), LENGTHS[0] + LENGTHS[1] * cos(turn));
    const double q2 = atan2(out, along) - LEAN - inner;
    turned(AXIS_1, q1, A);
    turned(AXIS_2, q2 + ELBOW_SIGN * q3, B);
    product(A, B, M);
    product(M, BALL_BASIS, A);
    product_of_transposed(A, target, M);
    for (int w = 0; w < 2; w++) {
        const int at = place + 6 * w;
        q[at] = q1;
        q[at + 1] = q2;
        q[at + 2] = q3;
        wrist(M, w == 0 ? 1.0 : -1.0, q, at);
        for (int i = 0; i < 6; i++) {
            q[at + i] = MIDDLE[i] + wrap(q[at + i] - MIDDLE[i]);
        }
    }
}

double inverse_kinematics(const double pose[16], double out[48])
{
    double w[3];
    double target[9];
    double least = UNLIMITED;
    wrist_centre(pose, target, w);
    const double radius = sqrt(w[0] * w[0] + w[1] * w[1]);
    const double lateral = fabs(LATERAL);
    const double root = sqrt(larger(radius - lateral, 0.0) * (radius + lateral));
    const double missing = radius + REACH_SLACK < lateral ? lateral - radius : 0.0;
    const double along = w[2] - SHOULDER[0];
    for (int s = 0; s < 2; s++) {
        const double front = s == 0 ? FRONT * root : -FRONT * root;
        const double ahead = atan2(w[1], w[0]) - atan2(LATERAL, front);
        const double q1 = radius < ALIGNED ? MIDDLE[0] : ahead;
        const double distance = sqrt(along * along + (front - SHOULDER[1]) * (front - SHOULDER[1]));
        const double bend = elbow_bend(distance);
        const double short_of = reach_excess(distance);
        const double excess = short_of < missing ? missing : short_of;
        if (!(excess >= least)) {
            least = excess;
        }
        for (int e = 0; e < 2; e++) {
            elbow_branches(target, q1, along, front - SHOULDER[1], e == 0 ? bend : -bend, out, 24 * s + 12 * e);
        }
        for (int i = 24 * s; i < 24 * s + 24; i++) {
            out[i] = excess <= 0.0 ? out[i] : (double)NAN;
        }
    }
    return least;
}
