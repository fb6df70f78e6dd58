"""Runs of a study in chunks: on threads, processes or a cluster, killed and resumed, in a folder of results.

sweep         every chunk that is missing, made and written
workshop      SweepWorkshop: a study in one thread, its runs in rows, by kernel or by `simulate`
cost          what a sweep will cost, measured on its first runs
sweep_folder  the folder of a sweep and its manifest; files written whole or not at all; SweepResults: it as arrays
chunk_file    the runs of a chunk as a Parquet file
schedulers    chunks by threads, and by processes that may die
cluster       chunks on a Dask cluster
"""
