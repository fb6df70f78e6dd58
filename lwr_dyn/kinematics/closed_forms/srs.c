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

/* from shoulder to wrist, the elbow's direction at the arm angle 0, and across (unit vectors); the rotation that
   the wrist shall bring about; gives the wrist's distance */
static double triangle(const double *pose, double *u, double *up, double *across, double *target)
{
    double R[9];
    double w[3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            R[3 * i + j] = pose[4 * i + j];
        }
        w[i] = pose[4 * i + 3] - SHOULDER[i];
    }
    moved(R, WRIST_IN_FLANGE, w, u);
    const double distance = sqrt(dot(u, u));
    for (int i = 0; i < 3; i++) {
        u[i] = distance > ON_AXIS ? u[i] / distance : REFERENCE[i];
    }
    upward(u, up);
    cross(u, up, across);
    product(R, HOME_BACK, target);
    return distance;
}

/* with joints 1 to 3 at 0: the direction from shoulder to wrist, the one across, and the ball of the wrist */
static void bent_arm(double q4, double *reach, double *side, double *last)
{
    double bent[9];
    turned(ELBOW_AXIS, q4, bent);
    moved(bent, FORE, UPPER, reach);
    const double length = larger(sqrt(dot(reach, reach)), ON_AXIS);
    for (int i = 0; i < 3; i++) {
        reach[i] = reach[i] / length;
    }
    cross(reach, ELBOW_AXIS, side);
    product(bent, LAST_BASIS, last);
}

/* the rotations of both balls where S turns the upper arm */
static void ball_rotations(const double *S, const double *last, const double *target, double *first, double *second)
{
    double M[9];
    product(FIRST_TURNED, S, M);
    product(M, FIRST_BACK, first);
    product(S, last, M);
    product_of_transposed(M, target, second);
}

/*
 * Rotations of shoulder F[0..26] and wrist F[27..53] over the arm angle: coefficients of cos, sin, 1 by row and column;
 * F[54] is the elbow's joint angle. Returns by how much the wrist is out of reach.
 */
static double forms(const double *pose, double elbow, double *F)
{
    double u[3];
    double up[3];
    double across[3];
    double target[9];
    double reach[3];
    double side[3];
    double last[9];
    double S[9];
    double first[9];
    double second[9];
    const double distance = triangle(pose, u, up, across, target);
    F[54] = STRAIGHT + elbow * elbow_bend(distance);
    bent_arm(F[54], reach, side, last);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                const double cosine = elbow * (up[i] * side[j] - across[i] * ELBOW_AXIS[j]);
                const double sine = elbow * (up[i] * ELBOW_AXIS[j] + across[i] * side[j]);
                S[3 * i + j] = k == 0 ? cosine : k == 1 ? sine : u[i] * reach[j];
            }
        }
        ball_rotations(S, last, target, first, second);
        for (int i = 0; i < 9; i++) {
            F[9 * k + i] = first[i];
            F[27 + 9 * k + i] = second[i];
        }
    }
    return reach_excess(distance);
}

/* roll, tilt, roll of a ball's rotation, the tilt from 0 to pi, into q[place] and the two after it; gives 1 where both
   rolls turn about one line, which share their sum evenly between their ranges */
static int ball(const double *M, int joint, double *q, int place)
{
    double roll = atan2(M[5], M[2]);
    const int is_aligned = M[2] * M[2] + M[5] * M[5] < ALIGNED * ALIGNED ? 1 : 0;
    if (is_aligned == 1) {
        const double turn = M[8] > 0.0 ? MIDDLE[joint + 2] : -MIDDLE[joint + 2];
        roll = MIDDLE[joint] + wrap(atan2(-M[1], M[4]) - MIDDLE[joint] - turn) / 2.0;
    }
    const double C = cos(roll);
    const double S = sin(roll);
    q[place] = roll;
    q[place + 1] = atan2(C * M[2] + S * M[5], M[8]) - OFFSETS[joint];
    q[place + 2] = atan2(C * M[3] - S * M[0], C * M[4] - S * M[1]);
    return is_aligned;
}

/* a ball's angles of the other sign of the tilt: both rolls half a turn on; from q[from] to out[place] */
static void other_ball(const double *q, int from, int joint, int is_aligned, double *out, int place)
{
    const double turn = is_aligned == 1 ? 0.0 : HALF_TURN;
    const double tilt = -(q[from + 1] + OFFSETS[joint]) - OFFSETS[joint];
    out[place] = q[from] + turn;
    out[place + 1] = is_aligned == 1 ? q[from + 1] : tilt;
    out[place + 2] = q[from + 2] + turn;
}

/* each joint within half a turn of the middle of its range */
static void wrap_joints(double *q, int place)
{
    for (int i = 0; i < 7; i++) {
        q[place + i] = MIDDLE[i] + wrap(q[place + i] - MIDDLE[i]);
    }
}

/* one branch at an arm angle given by its cosine and sine */
static void branch(const double *F, double c, double s, double shoulder, double wrist, double *q, int place)
{
    double first[9];
    double second[9];
    for (int i = 0; i < 9; i++) {
        first[i] = c * F[i] + s * F[9 + i] + F[18 + i];
        second[i] = c * F[27 + i] + s * F[36 + i] + F[45 + i];
    }
    const int is_first = ball(first, 0, q, place);
    const int is_second = ball(second, 4, q, place + 4);
    q[place + 3] = F[54];
    if (shoulder < 0.0) {
        other_ball(q, place, 0, is_first, q, place);
    }
    if (wrist < 0.0) {
        other_ball(q, place + 4, 4, is_second, q, place + 4);
    }
    wrap_joints(q, place);
}

double inverse_kinematics(const double pose[16], double arm_angle, double out[56])
{
    double u[3];
    double up[3];
    double across[3];
    double target[9];
    double reach[3];
    double side[3];
    double last[9];
    double S[9];
    double first[9];
    double second[9];
    const double c = cos(arm_angle);
    const double s = sin(arm_angle);
    const double distance = triangle(pose, u, up, across, target);
    const double bend = elbow_bend(distance);
    const double excess = reach_excess(distance);
    for (int e = 0; e < 2; e++) {
        const double elbow = e == 0 ? 1.0 : -1.0;
        const int at = 14 * e;
        out[at + 3] = STRAIGHT + elbow * bend;
        bent_arm(out[at + 3], reach, side, last);
        for (int i = 0; i < 3; i++) {
            const double along = elbow * (c * up[i] + s * across[i]);
            const double aside = elbow * (s * up[i] - c * across[i]);
            for (int j = 0; j < 3; j++) {
                S[3 * i + j] = along * side[j] + aside * ELBOW_AXIS[j] + u[i] * reach[j];
            }
        }
        ball_rotations(S, last, target, first, second);
        const int is_first = ball(first, 0, out, at);
        const int is_second = ball(second, 4, out, at + 4);
        for (int i = 0; i < 4; i++) {
            out[at + 7 + i] = out[at + i];
        }
        other_ball(out, at, 0, is_first, out, at + 28);
        other_ball(out, at + 4, 4, is_second, out, at + 11);
        for (int i = 0; i < 3; i++) {
            out[at + 32 + i] = out[at + 4 + i];
            out[at + 35 + i] = out[at + 28 + i];
            out[at + 39 + i] = out[at + 11 + i];
        }
        out[at + 31] = out[at + 3];
        out[at + 38] = out[at + 3];
    }
    for (int i = 0; i < 8; i++) {
        wrap_joints(out, 7 * i);
    }
    for (int i = 0; i < 56; i++) {
        out[i] = excess <= 0.0 ? out[i] : (double)NAN;
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
