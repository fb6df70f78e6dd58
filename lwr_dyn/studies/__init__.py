"""Many closed loops side by side.

compare  controllers x plants: one table, figures, a page
sweep    runs with parameters that vary, here or on a Dask cluster; gains for a stated aim
"""
