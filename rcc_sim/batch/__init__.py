"""Many runs and many logs: here, in several processes, or on a Dask cluster."""
