//! Plain f64 answers from normals, never from baked bytes.
