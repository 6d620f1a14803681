//! The cookie of a browser that has logged in.

use asmotion_monitor::BearerToken;
use serde_json::json;

use crate::Fixture;

const TOKEN: &str = "5ec2e7";

fn controlled() -> Fixture {
    Fixture::open(|settings| settings.control = Some(BearerToken::new(TOKEN)))
}

fn own(fixture: &Fixture) -> String {
    format!("http://{}", fixture.address())
}

/// Logs in as the page does. Returns the cookie with its attributes.
fn log_in(fixture: &Fixture) -> String {
    let headers = format!(
        "{}Origin: {}\r\nAuthorization: Bearer {TOKEN}\r\n",
        fixture.host(),
        own(fixture)
    );
    let (head, body) = fixture.send("POST", "/login", &headers);
    assert!(head.starts_with("HTTP/1.1 204"), "{head}");
    assert_eq!(body, "");
    let mut lines = head.lines();
    let cookie = lines.find_map(|line| line.strip_prefix("set-cookie: "));
    cookie.unwrap_or_else(|| panic!("{head}")).to_owned()
}

/// The part of the cookie that a browser sends.
fn sent(cookie: &str) -> &str {
    cookie.split(';').next().unwrap()
}

#[test]
fn a_browser_that_has_logged_in_controls_the_system_without_the_token() {
    let fixture = controlled();
    let orders = fixture.serve_orders();
    let cookie = log_in(&fixture);
    let attributes: Vec<_> = cookie.split("; ").skip(1).collect();
    assert_eq!(attributes, ["Path=/live", "HttpOnly", "SameSite=Strict"]);
    let own = own(&fixture);
    let mut client = fixture
        .connect_with(Some(&own), Some(sent(&cookie)))
        .unwrap();
    assert_eq!(client.next()["known"], true);
    // it is armed on request only, as with the token
    let order = json!({ "type": "order", "id": 7, "component": "Driver", "wish": "stop" });
    client.send(&order);
    assert_eq!(client.reply()["type"], "problem");
    client.send(&json!({ "type": "arm" }));
    assert_eq!(client.reply()["type"], "armed");
    client.send(&order);
    assert_eq!(client.reply(), json!({ "type": "done", "id": 7 }));
    assert!(orders.try_recv().is_ok());
    // one that has not logged in
    let mut other = fixture.connect(Some(&own)).unwrap();
    assert_eq!(other.next()["known"], false);
    other.send(&json!({ "type": "arm" }));
    let refused = other.reply()["text"].as_str().unwrap().to_owned();
    assert!(refused.contains("wrong token"), "{refused}");
}

#[test]
fn a_cookie_does_not_help_pages_of_other_servers_and_programs() {
    let fixture = controlled();
    let cookie = log_in(&fixture);
    let cookie = sent(&cookie);
    let port = fixture.address().port();
    let foreign = [
        "http://evil.example".to_owned(),
        "null".to_owned(),
        // a server of the same machine gets the cookie from the browser, but its pages are not those of this one
        format!("http://127.0.0.1:{}", port ^ 1),
        format!("http://localhost:{port}"),
    ];
    for origin in &foreign {
        assert!(
            fixture.connect_with(Some(origin), Some(cookie)).is_err(),
            "{origin}"
        );
        let headers = format!("{}Origin: {origin}\r\nCookie: {cookie}\r\n", fixture.host());
        for path in ["/", "/live", "/login", "/api/system"] {
            for method in ["GET", "POST"] {
                let (head, _) = fixture.send(method, path, &headers);
                assert!(head.starts_with("HTTP/1.1 403"), "{method} {path}: {head}");
            }
        }
    }
    let rebound =
        format!("Host: evil.example\r\nOrigin: http://evil.example\r\nCookie: {cookie}\r\n");
    assert_eq!(fixture.status("/live", &rebound), "421");
    // without an origin it is no page, and has to present the token itself
    let mut program = fixture.connect_with(None, Some(cookie)).unwrap();
    assert_eq!(program.next()["known"], false);
    program.send(&json!({ "type": "arm" }));
    assert_eq!(program.reply()["type"], "problem");
    program.send(&json!({ "type": "arm", "token": TOKEN }));
    assert_eq!(program.reply()["type"], "armed");
}

#[test]
fn a_cookie_of_an_earlier_run_at_the_same_port_does_not_help() {
    let fixture = controlled();
    let own = own(&fixture);
    let name = format!("asmotion-control-{}", fixture.address().port());
    for stale in [
        format!("{name}=0123abcd"),
        format!("{name}="),
        "other=1".to_owned(),
    ] {
        let mut client = fixture.connect_with(Some(&own), Some(&stale)).unwrap();
        assert_eq!(client.next()["known"], false, "{stale}");
        client.send(&json!({ "type": "arm" }));
        assert_eq!(client.reply()["type"], "problem", "{stale}");
    }
    // the new one replaces it
    let both = format!("{name}=0123abcd; {}", sent(&log_in(&fixture)));
    let mut client = fixture.connect_with(Some(&own), Some(&both)).unwrap();
    assert_eq!(client.next()["known"], true);
}

#[test]
fn nobody_logs_in_without_the_token_or_from_elsewhere() {
    let fixture = controlled();
    let (host, own) = (fixture.host(), own(&fixture));
    let status = |method: &str, headers: &str| {
        let (head, _) = fixture.send(method, "/login", headers);
        assert!(!head.contains("set-cookie"), "{head}");
        head.split(' ').nth(1).unwrap().to_owned()
    };
    let page = format!("{host}Origin: {own}\r\n");
    let right = format!("Authorization: Bearer {TOKEN}\r\n");
    assert_eq!(status("POST", &page), "401");
    for wrong in ["Bearer 5ec2e", "Bearer ", "Basic 5ec2e7", "5ec2e7"] {
        let headers = format!("{page}Authorization: {wrong}\r\n");
        assert_eq!(status("POST", &headers), "401", "{wrong}");
    }
    assert_eq!(status("POST", &format!("{host}{right}")), "401");
    assert_eq!(status("GET", &format!("{page}{right}")), "405");
    let foreign = format!("{host}Origin: http://evil.example\r\n{right}");
    assert_eq!(status("POST", &foreign), "403");
    // without `--control`, there is nothing to log in for
    let view_only = Fixture::open(|_| {});
    let headers = format!(
        "{}Origin: http://{}\r\n{right}",
        view_only.host(),
        view_only.address()
    );
    let (head, _) = view_only.send("POST", "/login", &headers);
    assert!(head.starts_with("HTTP/1.1 401"), "{head}");
}
