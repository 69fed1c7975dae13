//! Stage 6: the film: exact sums of every replicate, and from them mean, error and invalid samples.
