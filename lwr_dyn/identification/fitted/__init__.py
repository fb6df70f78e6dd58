"""A fitted arm as a model that every command takes (`lwr-dyn identify motion ... --out`).

fitted_values  bodies, rotors and friction of a fit with their standard errors, and the logs that they come from
fitted_arm     the arm with them, each number with its source
paper_text     a data file with them in place of the table's
fitted_files   write_fitted: .toml, or .urdf with its sidecars
"""
