/* sine and cosine: x less half turns, a polynomial of its square; of |x| up to 1.6e6 */
static double sine_or_cosine(double x, int is_cosine)
{
    const double scaled = x * PER_HALF_TURN;
    const double turns = (scaled + MAGIC) - MAGIC;
    const double pairs = (turns * 0.5 + MAGIC) - MAGIC;
    const double odd = turns - 2.0 * pairs;
    const double sign = 1.0 - 2.0 * (odd * odd);
    const double r = (x - turns * PI_PARTS[0]) - (turns * PI_PARTS[1] + turns * PI_PARTS[2]);
    const double square = r * r;
    double total = is_cosine == 1 ? COSINE[0] : SINE[0];
    if (is_cosine == 1) {
        for (int i = 1; i < COSINE_TERMS; i++) {
            total = total * square + COSINE[i];
        }
        return sign * ((1.0 - 0.5 * square) + square * square * total);
    }
    for (int i = 1; i < SINE_TERMS; i++) {
        total = total * square + SINE[i];
    }
    return sign * r + sign * r * square * total;
}

static double own_sin(double x)
{
    return sine_or_cosine(x, 0);
}

static double own_cos(double x)
{
    return sine_or_cosine(x, 1);
}

/* the angle of (x, y): eighths of a turn and the arctangent of at most 1/2 in size; NaN where both are infinite */
static double own_atan2(double y, double x)
{
    const double along = fabs(x);
    const double across = fabs(y);
    const double steep = across > along ? 1.0 : 0.0;
    const double back = copysign(1.0, x) < 0.0 ? 1.0 : 0.0;
    const double least = across > along ? along : across;
    const double most = across > along ? across : along;
    const double middle = least > 0.5 * most ? 1.0 : 0.0;
    const double top = least > 0.5 * most ? least - most : least;
    const double bottom = least > 0.5 * most ? least + most : most;
    const double t = bottom > 0.0 ? top / bottom : top + bottom;
    const double square = t * t;
    double total = ARCTANGENT[0];
    for (int i = 1; i < ARCTANGENT_TERMS; i++) {
        total = total * square + ARCTANGENT[i];
    }
    const double sense = (1.0 - 2.0 * steep) * (1.0 - 2.0 * back);
    const double eighths = (across > along ? 2.0 : 4.0 * back) + sense * middle;
    const double turned_by = sense * t;
    const double angle = eighths * EIGHTH + (turned_by + (eighths * EIGHTH_REST + turned_by * square * total));
    return copysign(angle, y);
}

/* near 0 and half a turn by the tangent of half the angle */
static double own_acos(double x)
{
    const double size = fabs(x);
    const double tangent = sqrt((1.0 - size) / (1.0 + size));
    if (size < 0.9) {
        return own_atan2(sqrt((1.0 - x) * (1.0 + x)), x);
    }
    return 2.0 * (x < 0.0 ? own_atan2(1.0, tangent) : own_atan2(tangent, 1.0));
}
