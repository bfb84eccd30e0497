//! The program, run as its users run it from a command line.

mod check;
mod check_scene;
mod checkpoint;
mod command_line;
mod compare;
mod convert;
mod faults;
mod lost_digits;
mod meant;
mod parts;
mod report;
mod without_window;
