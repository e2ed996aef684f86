//! The tests of the lab in one program: by itself each file would have all that it uses compiled
//! and linked anew.

mod claims;
mod golden;
mod joint;
mod methods;
