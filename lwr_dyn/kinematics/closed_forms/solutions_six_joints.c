/* all solutions of a pose: branches, singularities nearby (1 shoulder, 2 elbow, 4 wrist), and what `judged` finds */
int solutions(const double pose[16], double out[176])
{
    double T[12];
    double w[3];
    if (made_exact(pose, T) == 1) {
        return 1;
    }
    out[LEAST] = inverse_kinematics(T, out);
    judged(T, out);
    wrist_centre(T, w);
    const double radius = sqrt(w[0] * w[0] + w[1] * w[1]);
    const double shoulder = radius - fabs(LATERAL) < NEAR_SINGULAR ? 1.0 : 0.0;
    for (int b = 0; b < 8; b++) {
        out[SINGULAR + b] = 0.0;
        if (out[6 * b] <= UNLIMITED) {
            const double bend = fabs(wrap(out[6 * b + 2] - STRAIGHT));
            const double tilt = fabs(wrap(out[6 * b + 4] + OFFSET));
            const double elbow = smaller(bend, HALF_TURN - bend) < NEAR_SINGULAR ? 2.0 : 0.0;
            const double wrist = smaller(tilt, HALF_TURN - tilt) < NEAR_SINGULAR ? 4.0 : 0.0;
            out[SINGULAR + b] = shoulder + elbow + wrist;
        }
    }
    return 0;
}
