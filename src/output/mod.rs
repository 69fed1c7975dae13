//! Stage 7: pictures and reports, written whole or not at all.
