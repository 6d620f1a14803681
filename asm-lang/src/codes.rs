//! What every code means: a page for each, with a small wrong program and the same one mended.
//!
//! The pages stand in the folder `codes`: the first line is the meaning in one sentence, the first
//! fenced block marked `wrong` earns the finding, the one marked `mended` does not. A test tries them.

/// A code and its page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Code {
    /// As in `A014`.
    pub name: &'static str,
    /// The whole page.
    pub page: &'static str,
}

impl Code {
    /// What it means, in one sentence.
    pub fn meaning(&self) -> &'static str {
        let line = self.page.lines().next().unwrap_or("");
        line.split_once(": ").map_or(line, |(_, meaning)| meaning)
    }

    /// The text of the fenced block with this info string, as in `asm wrong`.
    pub fn example(&self, info: &str) -> Option<&'static str> {
        let (_, rest) = self.page.split_once(&format!("```{info}\n"))?;
        rest.split_once("```").map(|(example, _)| example)
    }
}

macro_rules! codes {
    ($($name:ident)*) => {
        &[$(Code {
            name: stringify!($name),
            page: include_str!(concat!("../codes/", stringify!($name), ".md")),
        },)*]
    };
}

/// The codes of the language and of its runs, by family: L what is read, A what is analysed, W what
/// works and is probably not meant, R what happens at run time, S the scripts of inputs, V scenarios.
pub const CODES: &[Code] = codes! {
    L001 L002 L003 L004 L005 L006 L007 L008 L009 L010 L011 L020 L021 L022 L023 L024 L025 L030
    L031 L032 L033 L034 L035 L036 L037 L038 L039 L040 L041 L050 L051 L052 L053 L054 L055 L056
    L057 L058 L059 L060 L061 L062 L063 L070 L071 L072 L073 L074 L075 L076
    A001 A002 A003 A004 A005 A006 A007 A008 A009 A010 A011 A012 A013 A014 A015 A016 A018 A019
    A020 A021 A023 A024 A025 A026 A027 A028 A031 A032 A033 A034 A035 A036 A040 A041
    W001 W002 W003 W004 W005 W006 W007 W020 W021 W022 W023 W024 W025 W026 W027 W028 W029
    W030
    R001 R002 R003 R004 R005 R006 R007 R008 R009 R010 R011 R012 R013 R014 R015 R016 R017 R020
    R021 R022 R023
    S000 S001 S002 S003 S004 S005 S006
    V001 V002 V003 V004 V005 V006 V007 V008 V009 V010 V011 V012 V013 V014 V015 V016 V017 V018
    V019 V020 V021 V022 V023 V024 V030 V031
};
