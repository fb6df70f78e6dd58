"""Closed loops in time: plant, friction, stops, sensors, integrators, the audit, and figures of merit.

arm_friction      Friction of the simulated arm: set-valued with true stick, its smooth form, none, or a function of
                  the caller
audit             The audit of a run: its energy must be the work of the channels; its motion, by another engine, that
                  of its torques
contact           Joints at rest and joints that move: impacts at stops, which joints stick, slip or leave a stop, and
                  what ends that
elastic           Arms with elastic joints: a spring and a damper between the motor side and the link side of every
                  gear
flow              Integrates one interval and handles every event in it: impacts at stops, joints that stick or are
                  released
integrators       From a state to the state after a step: Runge-Kutta of order 4 in fixed steps, and an adaptive
                  reference
loops             The loops of a run: one for sampled controllers, with a fast path for the usual step, and one for
                  continuous ones
metrics           Figures of merit of a run: errors joint by joint, error of the tip, torques and speeds against their
                  limits
plant             The plant, which need not be the arm that the controller models; external torques on it; the
                  encoders that read it
setup             `Loop`: what closes a loop; `prepare`: arm, controller, reference and loop, checked, as a `Setup`
                  that can be run
simulate          `simulate`: an arm, a controller and a reference become a `Run` that records its setup and its audit
step_and_chirp    What a run answers to steps (rise, overshoot, settling) and to chirps (frequency response,
                  bandwidth)
stiff             The loop "stiff" of `simulate`: a controller at every moment and a plant that moves smoothly, by an
                  implicit method
substeps          How many RK4 steps a sample a run needs: as many that twice as many change its tip by less than
                  1e-6 m
walls_and_pushes  A push at a point of the arm, and a compliant wall that its tip touches: external torques
"""
