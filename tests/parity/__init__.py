"""What other engines make of a model file: one loader an engine, one protocol, one comparison.

`tests/agreement/test_committed_models.py` runs it on samples, `scripts/soak.py parity` prints the whole table.
"""
