//! From a description to a picture.
