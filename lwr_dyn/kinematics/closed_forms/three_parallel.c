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

/* two branches, one of each sign of the elbow, with the sum of joints 2 to 4 as `roll` says and q1, q5, q6 as they are in
   W[3] and after; gives by how much they are out of reach */
static double planar_branches(double roll, const double *W, double *q, int place)
{
    const double c = cos(roll);
    const double s = sin(roll);
    const double x = W[0] - (LEVER[0] * c - SENSE * LEVER[1] * s);
    const double y = W[1] - (SENSE * LEVER[0] * s + LEVER[1] * c);
    const double distance = sqrt(x * x + y * y);
    const double excess = larger(reach_excess(distance), W[2]);
    if (!(excess <= 0.0)) {
        for (int i = place; i < place + 6; i++) {
            q[i] = (double)NAN;
            q[i + 12] = (double)NAN;
        }
        return excess;
    }
    const double bend = elbow_bend(distance);
    const double lean = atan2(y, x) - LEAN;
    const double inner = atan2(LENGTHS[1] * sin(bend), LENGTHS[0] + LENGTHS[1] * cos(bend));
    for (int e = 0; e < 2; e++) {
        const int at = place + 12 * e;
        const double q2 = e == 0 ? lean - inner : lean + inner;
        const double q3 = e == 0 ? STRAIGHT + ELBOW_SIGN * bend : STRAIGHT - ELBOW_SIGN * bend;
        q[at] = W[3];
        q[at + 1] = near_middle(q2, 1);
        q[at + 2] = near_middle(q3, 2);
        q[at + 3] = near_middle(roll - SENSE * (q2 + ELBOW_SIGN * q3), 3);
        q[at + 4] = W[4];
        q[at + 5] = W[5];
    }
    return excess;
}

double inverse_kinematics(const double pose[16], double out[48])
{
    double w[3];
    double root[1];
    double target[9];
    double A[9];
    double M[9];
    double W[6];
    double least = UNLIMITED;
    wrist_centre(pose, w);
    wrist_rotation(pose, target);
    W[2] = shoulder_gap(w, root);
    W[0] = w[2] - SHOULDER[0];
    for (int s = 0; s < 2; s++) {
        const double front = s == 0 ? FRONT * root[0] : -FRONT * root[0];
        const double q1 = shoulder_angle(w, front);
        W[1] = front - SHOULDER[1];
        turned_back(target, q1, 0, 1, A);
        product(BALL_TURNED, A, M);
        const double sine = sqrt(M[2] * M[2] + M[5] * M[5]);
        const double turn = sine < ALIGNED ? 0.0 : HALF_TURN;
        const double roll = sine < ALIGNED ? SENSE * reachable_turn(W[0], W[1]) : atan2(M[5], M[2]);
        const double c = cos(roll);
        const double a = sin(roll);
        const double tilt = atan2(sine, M[8]);
        const double q6 = atan2(c * M[3] - a * M[0], c * M[4] - a * M[1]);
        W[3] = near_middle(q1, 0);
        W[4] = near_middle(tilt - OFFSET, 4);
        W[5] = near_middle(q6, 5);
        const double ahead = planar_branches(roll, W, out, 24 * s);
        W[4] = near_middle(-tilt - OFFSET, 4);
        W[5] = near_middle(q6 + turn, 5);
        const double behind = planar_branches(roll + turn, W, out, 24 * s + 6);
        const double excess = smaller(ahead, behind);
        if (!(excess >= least)) {
            least = excess;
        }
    }
    return least;
}
