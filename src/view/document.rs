//! The page: one document, put together from its parts when the program is compiled.

use super::connection::Response;

const DOCUMENT: &str = include_str!("page/index.html");
const STYLE: &str = include_str!("page/style.css");
const SCRIPTS: [&str; 7] = [
    include_str!("page/camera.js"),
    include_str!("page/server.js"),
    include_str!("page/picture.js"),
    include_str!("page/pointer.js"),
    include_str!("page/panels.js"),
    include_str!("page/keep.js"),
    include_str!("page/page.js"),
];

/// The page, which may run only its own scripts, and talk only to its own server.
pub(super) fn page(nonce: &str) -> Response {
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; connect-src 'self'; \
         img-src blob: data:; form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
    );
    let document = DOCUMENT.replace("{nonce}", nonce);
    let document = document.replace("{style}", STYLE);
    let document = document.replace("{script}", &SCRIPTS.concat());
    Response::new(200, "text/html; charset=utf-8", document.into_bytes())
        .with_header("Content-Security-Policy", policy)
}
