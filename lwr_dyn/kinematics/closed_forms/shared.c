static const double HALF_TURN = 3.141592653589793;
static const double TURN = 6.283185307179586;
static const double ALIGNED = 1e-13;
static const double TOUCH = 1e-12;

/* NaN passes where it is the first number */
static double smaller(double a, double b)
{
    return b < a ? b : a;
}

static double larger(double a, double b)
{
    return b > a ? b : a;
}

/* the angle within -pi and pi */
static double wrap(double x)
{
    const double y = HALF_TURN - x;
    return HALF_TURN - (y - TURN * floor(y / TURN));
}

/* a b */
static void product(const double *a, const double *b, double *out)
{
    for (int i = 0; i < 9; i += 3) {
        for (int j = 0; j < 3; j++) {
            out[i + j] = a[i] * b[j] + a[i + 1] * b[j + 3] + a[i + 2] * b[j + 6];
        }
    }
}

/* a^T b */
static void product_of_transposed(const double *a, const double *b, double *out)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            out[3 * i + j] = a[i] * b[j] + a[i + 3] * b[j + 3] + a[i + 6] * b[j + 6];
        }
    }
}

/* a v + w, from place i of v and w on */
static void moved(const double *a, const double *v, const double *w, double *out)
{
    for (int i = 0; i < 3; i++) {
        out[i] = a[3 * i] * v[0] + a[3 * i + 1] * v[1] + a[3 * i + 2] * v[2] + w[i];
    }
}

static void cross(const double *a, const double *b, double *out)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* the rotation about a unit axis (Rodrigues) */
static void turned(const double *axis, double angle, double *out)
{
    const double s = sin(angle);
    const double c = cos(angle);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            out[3 * i + j] = (1.0 - c) * axis[i] * axis[j];
        }
        out[4 * i] += c;
    }
    out[1] -= s * axis[2];
    out[2] += s * axis[1];
    out[3] += s * axis[2];
    out[5] -= s * axis[0];
    out[6] -= s * axis[1];
    out[7] += s * axis[0];
}

/* the elbow's angle from straight for the wrist at a distance from the shoulder */
static double elbow_bend(double distance)
{
    const double above = larger(LENGTHS[0] + LENGTHS[1] - distance, 0.0) * (LENGTHS[0] + LENGTHS[1] + distance);
    const double least = fabs(LENGTHS[0] - LENGTHS[1]);
    return 2.0 * atan2(sqrt(above), sqrt(larger(distance - least, 0.0) * (distance + least)));
}

/* by how much the wrist is out of reach, 0 within */
static double reach_excess(double distance)
{
    const double far = distance - LENGTHS[0] - LENGTHS[1];
    const double excess = larger(far, fabs(LENGTHS[0] - LENGTHS[1]) - distance);
    return excess <= REACH_SLACK ? 0.0 : excess;
}

/* q by whole turns nearest to `near` inside the limits; where there is none, the one within half a turn of the middle */
static double nearest_turn(double q, double near, int joint)
{
    const double room = HALF[joint] + TOUCH;
    const double away = q - MIDDLE[joint];
    const double wanted = floor((near - q) / TURN + 0.5);
    const double least = -floor((room + away) / TURN);
    const double most = floor((room - away) / TURN);
    return least > most ? q : q + TURN * smaller(larger(wanted, least), most);
}

/* the smallest distance of q[at] and the joints after it from a limit, negative outside */
static double smallest_margin(const double *q, int at)
{
    double smallest = UNLIMITED;
    for (int i = 0; i < JOINTS; i++) {
        const double margin = HALF[i] - fabs(q[at + i] - MIDDLE[i]);
        if (!(margin >= smallest)) {
            smallest = margin;
        }
    }
    return smallest;
}
