/* turn of the lever about axis 4 that brings axis 4 nearest to where the elbow is at a right angle */
static double reachable_turn(double along, double out)
{
    const double distance = sqrt(along * along + out * out);
    const double lever = sqrt(LEVER[0] * LEVER[0] + LEVER[1] * LEVER[1]);
    const double right = sqrt(LENGTHS[0] * LENGTHS[0] + LENGTHS[1] * LENGTHS[1]);
    const double wanted = smaller(larger(right, fabs(distance - lever)), distance + lever);
    const double twice = larger(2.0 * distance * lever, 1e-300);
    const double cosine = (distance * distance + lever * lever - wanted * wanted) / twice;
    return atan2(out, along) - atan2(LEVER[1], LEVER[0]) + acos(smaller(larger(cosine, -1.0), 1.0));
}

/* two branches, one of each sign of the elbow, with the wrist centre at `along`, `out` of axis 2; M turns the ball */
static double planar_branches(const double *M, double q1, double sign, double along, double out, double *q, int place)
{
    const double sine = sqrt(M[2] * M[2] + M[5] * M[5]);
    const double roll = sine < ALIGNED ? SENSE * reachable_turn(along, out) : atan2(sign * M[5], sign * M[2]);
    const double c = cos(roll);
    const double s = sin(roll);
    const double x = along - (LEVER[0] * c - SENSE * LEVER[1] * s);
    const double y = out - (SENSE * LEVER[0] * s + LEVER[1] * c);
    const double distance = sqrt(x * x + y * y);
    const double bend = elbow_bend(distance);
    const double lean = atan2(y, x) - LEAN;
    const double q5 = atan2(sign * sine, M[8]) - OFFSET;
    const double q6 = atan2(c * M[3] - s * M[0], c * M[4] - s * M[1]);
    for (int e = 0; e < 2; e++) {
        const int at = place + 12 * e;
        const double turn = e == 0 ? bend : -bend;
        const double q2 = lean - atan2(LENGTHS[1] * sin(turn), LENGTHS[0] + LENGTHS[1] * cos(turn));
        const double q3 = STRAIGHT + ELBOW_SIGN * turn;
        q[at] = q1;
        q[at + 1] = q2;
        q[at + 2] = q3;
        q[at + 3] = roll - SENSE * (q2 + ELBOW_SIGN * q3);
        q[at + 4] = q5;
        q[at + 5] = q6;
        for (int i = 0; i < 6; i++) {
            q[at + i] = MIDDLE[i] + wrap(q[at + i] - MIDDLE[i]);
        }
    }
    return reach_excess(distance);
}

double inverse_kinematics(const double pose[16], double out[48])
{
    double w[3];
    double target[9];
    double A[9];
    double M[9];
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
        turned(AXIS_1, q1, A);
        product(A, BALL_BASIS, M);
        product_of_transposed(M, target, A);
        for (int t = 0; t < 2; t++) {
            const int place = 24 * s + 6 * t;
            const double sign = t == 0 ? 1.0 : -1.0;
            const double short_of = planar_branches(A, q1, sign, along, front - SHOULDER[1], out, place);
            const double excess = short_of < missing ? missing : short_of;
            if (!(excess >= least)) {
                least = excess;
            }
            for (int i = place; i < place + 6; i++) {
                out[i] = excess <= 0.0 ? out[i] : (double)NAN;
                out[i + 12] = excess <= 0.0 ? out[i + 12] : (double)NAN;
            }
        }
    }
    return least;
}
