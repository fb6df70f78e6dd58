"""Runs of a study in chunks: on threads, processes or a cluster, killed and resumed, in a folder of results.

chunk_file    The runs of a chunk as columns, and these as a Parquet file that says what they are and what made them
cluster       Chunks on a Dask cluster that runs already: its scheduler is asked first, its workers' versions are
              compared, and a worker that dies costs time only
cost          What a sweep will cost, stated ahead: measured on its first runs
schedulers    Chunks by threads, and by processes for controllers in Python, where one that dies costs its chunk and
              no other
sweep         A sweep: every chunk of a study that its folder lacks is made and written; a killed one goes on from
              there
sweep_folder  The folder of a sweep: a manifest, a copy of the study, and for each controller a folder with a file a
              chunk
workshop      A study in one process: arm, references and controllers are built once, its runs made by kernel or
              `simulate`
"""
