static const double ON_AXIS = 1e-9;

/* the elbow's direction at the arm angle 0 */
static void upward(const double *u, double *up)
{
    const double along = dot(u, REFERENCE);
    const double sideways = dot(u, SPARE);
    for (int i = 0; i < 3; i++) {
        up[i] = REFERENCE[i] - along * u[i];
    }
    double length = sqrt(dot(up, up));
    if (!(length > ON_AXIS)) {
        for (int i = 0; i < 3; i++) {
            up[i] = SPARE[i] - sideways * u[i];
        }
        length = larger(sqrt(dot(up, up)), ON_AXIS);
    }
    for (int i = 0; i < 3; i++) {
        up[i] = up[i] / length;
    }
}

/*
 * Rotations of shoulder F[0..26] and wrist F[27..53] over the arm angle: coefficients of cos, sin, 1 by row and column;
 * F[54] is the elbow's joint angle. Returns by how much the wrist is out of reach.
 */
static double forms(const double *pose, double elbow, double *F)
{
    double R[9];
    double w[3];
    double u[3];
    double up[3];
    double across[3];
    double bent[9];
    double reach[3];
    double side[3];
    double target[9];
    double last[9];
    double S[9];
    double M[9];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            R[3 * i + j] = pose[4 * i + j];
        }
        w[i] = pose[4 * i + 3] - SHOULDER[i];
    }
    moved(R, WRIST_IN_FLANGE, w, u);
    const double distance = sqrt(dot(u, u));
    const double bend = elbow_bend(distance);
    for (int i = 0; i < 3; i++) {
        u[i] = distance > ON_AXIS ? u[i] / distance : REFERENCE[i];
    }
    upward(u, up);
    cross(u, up, across);
    F[54] = STRAIGHT + elbow * bend;
    turned(ELBOW_AXIS, F[54], bent);
    moved(bent, FORE, UPPER, reach);
    const double length = larger(sqrt(dot(reach, reach)), ON_AXIS);
    for (int i = 0; i < 3; i++) {
        reach[i] = reach[i] / length;
    }
    cross(reach, ELBOW_AXIS, side);
    product(R, HOME_BACK, target);
    product(bent, LAST_BASIS, last);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                const double cosine = elbow * (up[i] * side[j] - across[i] * ELBOW_AXIS[j]);
                const double sine = elbow * (up[i] * ELBOW_AXIS[j] + across[i] * side[j]);
                S[3 * i + j] = k == 0 ? cosine : k == 1 ? sine : u[i] * reach[j];
            }
        }
        product(FIRST_TURNED, S, M);
        product(M, FIRST_BACK, R);
        product(S, last, M);
        for (int i = 0; i < 9; i++) {
            F[9 * k + i] = R[i];
        }
        product_of_transposed(M, target, R);
        for (int i = 0; i < 9; i++) {
            F[27 + 9 * k + i] = R[i];
        }
    }
    return reach_excess(distance);
}

/* roll, tilt, roll of the ball whose forms begin at `at`, into q[place] and the two after it */
static void ball(const double *F, int at, double c, double s, double sign, int joint, double *q, int place)
{
    const double m00 = c * F[at] + s * F[at + 9] + F[at + 18];
    const double m01 = c * F[at + 1] + s * F[at + 10] + F[at + 19];
    const double m02 = c * F[at + 2] + s * F[at + 11] + F[at + 20];
    const double m10 = c * F[at + 3] + s * F[at + 12] + F[at + 21];
    const double m11 = c * F[at + 4] + s * F[at + 13] + F[at + 22];
    const double m12 = c * F[at + 5] + s * F[at + 14] + F[at + 23];
    const double m22 = c * F[at + 8] + s * F[at + 17] + F[at + 26];
    double roll = atan2(sign * m12, sign * m02);
    if (m02 * m02 + m12 * m12 < ALIGNED * ALIGNED) {
        const double turn = m22 > 0.0 ? MIDDLE[joint + 2] : -MIDDLE[joint + 2];
        roll = MIDDLE[joint] + wrap(atan2(-m01, m11) - MIDDLE[joint] - turn) / 2.0;
    }
    const double C = cos(roll);
    const double S = sin(roll);
    q[place] = roll;
    q[place + 1] = atan2(C * m02 + S * m12, m22) - OFFSETS[joint];
    q[place + 2] = atan2(C * m10 - S * m00, C * m11 - S * m01);
}

/* one branch at an arm angle given by its cosine and sine */
static void branch(const double *F, double c, double s, double shoulder, double wrist, double *q, int place)
{
    ball(F, 0, c, s, shoulder, 0, q, place);
    q[place + 3] = F[54];
    ball(F, 27, c, s, wrist, 4, q, place + 4);
    for (int i = 0; i < 7; i++) {
        q[place + i] = MIDDLE[i] + wrap(q[place + i] - MIDDLE[i]);
    }
}

double inverse_kinematics(const double pose[16], double arm_angle, double out[56])
{
    double F[55];
    const double c = cos(arm_angle);
    const double s = sin(arm_angle);
    double excess = 0.0;
    for (int e = 0; e < 2; e++) {
        excess = forms(pose, e == 0 ? 1.0 : -1.0, F);
        for (int b = 0; b < 4; b++) {
            branch(F, c, s, b < 2 ? 1.0 : -1.0, b % 2 == 0 ? 1.0 : -1.0, out, 7 * (b + 2 * (e + (b < 2 ? 0 : 1))));
        }
    }
    if (!(excess <= 0.0)) {
        for (int i = 0; i < 56; i++) {
            out[i] = (double)NAN;
        }
    }
    return excess;
}

/* the arm angle of a position, and its branch's signs of shoulder, elbow and wrist */
void inverse_kinematics_arm_angle(const double q[7], double out[4])
{
    double A[9];
    double B[9];
    double M[9];
    double R[9];
    double reach[3];
    double u[3];
    double up[3];
    double across[3];
    double n[3];
    double side[3];
    turned(AXIS_Z, q[0], A);
    turned(AXIS_Y, q[1] + OFFSETS[0], B);
    product(A, B, M);
    turned(AXIS_Z, q[2], A);
    product(M, A, B);
    product(FIRST_BASIS, B, M);
    product(M, FIRST_FRONT, R);
    turned(ELBOW_AXIS, q[3], B);
    moved(B, FORE, UPPER, reach);
    moved(R, reach, NOWHERE, u);
    moved(R, ELBOW_AXIS, NOWHERE, n);
    const double distance = larger(sqrt(dot(u, u)), ON_AXIS);
    for (int i = 0; i < 3; i++) {
        u[i] = u[i] / distance;
    }
    upward(u, up);
    cross(u, up, across);
    cross(u, n, side);
    out[1] = sin(q[1] + OFFSETS[0]) < 0.0 ? -1.0 : 1.0;
    out[2] = wrap(q[3] - STRAIGHT) < 0.0 ? -1.0 : 1.0;
    out[3] = sin(q[5] + OFFSETS[4]) < 0.0 ? -1.0 : 1.0;
    out[0] = atan2(out[2] * dot(side, across), out[2] * dot(side, up));
}
