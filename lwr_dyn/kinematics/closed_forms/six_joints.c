/* the wrist centre's place along e, n and axis 1, into w, and the rotation that the ball shall bring about */
static void wrist_centre(const double *pose, double *target, double *w)
{
    double R[9];
    double v[3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            R[3 * i + j] = pose[4 * i + j];
        }
        w[i] = pose[4 * i + 3] - ORIGIN[i];
    }
    product(R, HOME_BACK, target);
    moved(R, WRIST_IN_FLANGE, w, v);
    moved(FRAME_TURNED, v, NOWHERE, w);
}
