//! Everything that is tested through the front door: programs of the language, missions of the
//! robot, the command line, and the plan of the house itself. One module a subject.

mod language;
