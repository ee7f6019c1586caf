"""Many maps: jobs that read, score and describe one map each, and the pool that runs them."""
