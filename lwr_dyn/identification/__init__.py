"""Identification: logs of an arm that moved, the cruises in them, friction maps, fits, and regression on the model."""
