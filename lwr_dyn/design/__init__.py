"""Design of the sampled loop: where sampling makes a controller unstable at rest.

- `resting_plant`: RestingPlant, a plant near rest as matrices, its exact step with the torque held;
- `sampled_loop`: RestingLoop, the sampled loop at rest as a linear map, its spectral radius;
- `sampled_stability`: stability_in_box, stability_along: share of unstable poses, worst pose, least rate;
- `sampled_gains`: the sampled loops of all controllers with given gains;
- `command`: `lwr-dyn gains`;
- `sampled_text`: these results in words, for the commands `gains` and `simulate`.
"""
