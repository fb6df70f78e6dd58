"""A robot's arm as numbers: links, joints, drives, friction."""
