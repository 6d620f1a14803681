//! Query parameters of a call: `?timeout_ms=500&oneway=true`.

use std::time::Duration;

use crate::problem::Problem;

/// Limit on the timeout of a call.
const LONGEST: Duration = Duration::from_secs(24 * 3600);

/// Parameters of a call.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct CallParameters {
    /// `timeout_ms`; `None` for the service's default.
    pub timeout: Option<Duration>,
    /// `oneway`: the client does not wait for a response.
    pub one_way: bool,
}

impl CallParameters {
    /// Parses the query part of a URI. An unknown parameter is an error.
    pub(crate) fn of(query: Option<&str>) -> Result<Self, Problem> {
        let mut question = Self::default();
        let parts = query.unwrap_or_default().split('&');
        for part in parts.filter(|part| !part.is_empty()) {
            match part.split_once('=').unwrap_or((part, "")) {
                ("timeout_ms", value) => question.timeout = Some(timeout(value)?),
                ("oneway", "" | "true") => question.one_way = true,
                ("oneway", "false") => question.one_way = false,
                _ => {
                    return Err(Problem::Query {
                        part: part.to_owned(),
                    });
                }
            }
        }
        Ok(question)
    }
}

fn timeout(written: &str) -> Result<Duration, Problem> {
    let wrong = || Problem::Query {
        part: format!("timeout_ms={written}"),
    };
    let timeout = Duration::from_millis(written.parse().map_err(|_| wrong())?);
    if timeout.is_zero() || timeout > LONGEST {
        Err(wrong())
    } else {
        Ok(timeout)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_reads_what_it_knows_and_refuses_the_rest() {
        let of = |query| CallParameters::of(Some(query)).ok();
        let timeout = Some(Duration::from_millis(500));
        let expected = CallParameters {
            timeout,
            one_way: true,
        };
        assert_eq!(of("timeout_ms=500&oneway"), Some(expected));
        assert_eq!(of(""), Some(CallParameters::default()));
        for wrong in [
            "timeout_ms=0",
            "timeout_ms=-1",
            "timeout_ms=1e9",
            "timeout_ms=86400001",
            "oneway=1",
            "wait=1",
        ] {
            assert_eq!(of(wrong), None, "{wrong}");
        }
    }
}
