"""Runs of a study in chunks: on threads, processes or a cluster, killed and resumed, in a folder of results.

sweep             sweep: every chunk that is missing, made and written
workshop          SweepWorkshop: a study in one thread, its runs in rows
simulated_rows    runs of a controller without a kernel form, by `simulate`
first_runs        the first run of each controller without a kernel, in a process that may die
cost              what a sweep will cost, measured on its first runs
manifest          what made results: study, kernels, versions, processor; results of two makers are never mixed
sweep_folder      the folder of a sweep: files written whole or not at all, one writer, what a kill left is cleared
chunk_file        the runs of a chunk as a Parquet file
results           SweepResults: a folder as arrays
tasks, processes  chunks by threads, and by processes that may die
cluster           chunks on a Dask cluster
"""
