int inverse_kinematics_near(const double pose[16], const double q_near[6], double out[6])
{
    double all[48];
    double least = UNLIMITED;
    int found = 2;
    if (!(inverse_kinematics(pose, all) <= 0.0)) {
        return 3;
    }
    for (int at = 0; at < 48; at += 6) {
        if (smallest_margin(all, at) >= -TOUCH) {
            double distance = 0.0;
            for (int i = 0; i < 6; i++) {
                all[at + i] = nearest_turn(all[at + i], q_near[i], i);
                distance += (all[at + i] - q_near[i]) * (all[at + i] - q_near[i]);
            }
            if (distance < least) {
                least = distance;
                found = 0;
                for (int i = 0; i < 6; i++) {
                    out[i] = all[at + i];
                }
            }
        }
    }
    return found;
}
