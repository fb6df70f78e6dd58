/* the wrist centre's place along e, n and axis 1 */
static void wrist_centre(const double *pose, double *w)
{
    double v[3];
    for (int i = 0; i < 3; i++) {
        v[i] = pose[4 * i] * WRIST_IN_FLANGE[0] + pose[4 * i + 1] * WRIST_IN_FLANGE[1] +
            pose[4 * i + 2] * WRIST_IN_FLANGE[2] + (pose[4 * i + 3] - ORIGIN[i]);
    }
    moved(FRAME_TURNED, v, NOWHERE, w);
}

/* the rotation that the ball shall bring about, along e, n and axis 1 */
static void wrist_rotation(const double *pose, double *target)
{
    double R[9];
    double A[9];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            R[3 * i + j] = pose[4 * i + j];
        }
    }
    product(FRAME_TURNED, R, A);
    product(A, HOME_BACK, target);
}

/* rows i and j of A turned back by the angle that leads from i to j, the third kept, into out */
static void turned_back(const double *A, double angle, int i, int j, double *out)
{
    const double c = cos(angle);
    const double s = sin(angle);
    const int other = 3 - i - j;
    for (int k = 0; k < 3; k++) {
        out[3 * i + k] = c * A[3 * i + k] + s * A[3 * j + k];
        out[3 * j + k] = c * A[3 * j + k] - s * A[3 * i + k];
        out[3 * other + k] = A[3 * other + k];
    }
}

/* how far the wrist centre is too near to axis 1, 0 if it is not; and how far it is ahead, for q1, into root */
static double shoulder_gap(const double *w, double *root)
{
    const double radius = sqrt(w[0] * w[0] + w[1] * w[1]);
    const double lateral = fabs(LATERAL);
    root[0] = sqrt(larger(radius - lateral, 0.0) * (radius + lateral));
    return radius + REACH_SLACK < lateral ? lateral - radius : 0.0;
}

/* q1 with the wrist centre at `front` ahead; where it is on axis 1, the middle of the range */
static double shoulder_angle(const double *w, double front)
{
    const double radius = sqrt(w[0] * w[0] + w[1] * w[1]);
    const double ahead = atan2(w[1], w[0]) - atan2(LATERAL, front);
    return radius < ALIGNED ? MIDDLE[0] : ahead;
}

/* a joint's angle within half a turn of the middle of its range */
static double near_middle(double q, int joint)
{
    return MIDDLE[joint] + wrap(q - MIDDLE[joint]);
}
