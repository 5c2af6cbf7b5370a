//! The page in Chromium, narrow and wide, light and dark: no errors, nothing cut off.
//!
//! Only with `PHALANX_FULL`. `PHALANX_SHOTS=FOLDER` keeps pages and screenshots there for
//! inspection.

mod devtools;
mod view;

use crate::report::fixture::{self, compare};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use devtools::Browser;
use phalanx::report::BenchRecord;
use phalanx::report::html::{comparison_page, page, page_against};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// Window sizes of a telephone and of a desktop.
const WINDOWS: [(u32, u32); 2] = [(400, 800), (1400, 1000)];
const SCHEMES: [&str; 2] = ["light", "dark"];

/// Elements that extend beyond the window, except inside scrolling boxes.
const BEYOND: &str = "Array.from(document.querySelectorAll('body *'))
    .filter(e => !e.closest('.scroll') || e.matches('.scroll'))
    .filter(e => e.getBoundingClientRect().right > innerWidth + 0.5)
    .map(e => e.outerHTML.slice(0, 120))";

/// Chart texts that are cut off or too small to read.
const CUT: &str = "Array.from(document.querySelectorAll('svg text')).filter(t => t.checkVisibility()).filter(t => {
    const text = t.getBoundingClientRect(), svg = t.closest('svg').getBoundingClientRect();
    return text.left < svg.left - 1 || text.right > svg.right + 1 || text.top < svg.top - 1
        || text.bottom > svg.bottom + 1 || text.height < 9;
}).map(t => t.textContent)";

/// The smallest contrast of text with its background.
const CONTRAST: &str = "(() => {
    const part = v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
    const light = c => c.match(/[\\d.]+/g).slice(0, 3).map(part).reduce((s, v, i) => s + v * [0.2126, 0.7152, 0.0722][i], 0);
    const behind = e => {
        for (; e; e = e.parentElement) {
            const c = getComputedStyle(e).backgroundColor;
            if (c !== 'rgba(0, 0, 0, 0)') return c;
        }
        return 'rgb(255, 255, 255)';
    };
    let least = 99;
    for (const e of document.querySelectorAll('p, li, td, th, dt, dd, a, code, small, figcaption, caption, summary, h2, text')) {
        if (!e.checkVisibility()) continue;
        const style = getComputedStyle(e);
        const [a, b] = [light(e.tagName === 'text' ? style.fill : style.color), light(behind(e))];
        least = Math.min(least, (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05));
    }
    return least;
})()";

fn show(browser: &mut Browser, file: &Path, (width, height): (u32, u32), scheme: &str) {
    let metrics =
        json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
    browser.call("Emulation.setDeviceMetricsOverride", metrics);
    let feature = json!({ "name": "prefers-color-scheme", "value": scheme });
    browser.call(
        "Emulation.setEmulatedMedia",
        json!({ "features": [feature] }),
    );
    browser.events();
    let address = format!("file://{}", file.display());
    browser.call("Page.navigate", json!({ "url": address }));
    browser.wait_for("Page.loadEventFired");
}

/// Errors reported by the browser, and its network requests.
fn complaints(browser: &mut Browser) -> Vec<String> {
    let bad = |event: &Value| match event["method"].as_str() {
        Some("Log.entryAdded" | "Runtime.consoleAPICalled" | "Runtime.exceptionThrown") => true,
        Some("Network.loadingFailed") => true,
        Some("Network.requestWillBeSent") => {
            let address = event["params"]["request"]["url"]
                .as_str()
                .unwrap_or_default();
            !address.starts_with("file:") && !address.starts_with("data:")
        }
        _ => false,
    };
    let events = browser.events();
    events
        .iter()
        .filter(|e| bad(e))
        .map(Value::to_string)
        .collect()
}

/// Folder for pages and screenshots, if requested.
fn kept() -> Option<PathBuf> {
    std::env::var_os("PHALANX_SHOTS").map(PathBuf::from)
}

fn keep_shot(browser: &mut Browser, name: &str) {
    let Some(folder) = kept() else { return };
    let parameters = json!({ "format": "png", "captureBeyondViewport": true });
    let shot = browser.call("Page.captureScreenshot", parameters);
    let bytes = STANDARD.decode(shot["data"].as_str().expect("a picture"));
    let file = folder.join(format!("{name}.png"));
    fs::write(file, bytes.expect("base64")).expect("a screenshot");
}

/// The page of a record.
fn look(browser: &mut Browser, name: &str, record: &BenchRecord) {
    look_at(browser, name, &page(record, &fixture::pictures(record)));
}

/// A page in both widths and schemes, with all folds open the second time.
fn look_at(browser: &mut Browser, name: &str, text: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("report.html");
    fs::write(&file, text).expect("a page");
    if let Some(folder) = kept() {
        fs::write(folder.join(format!("{name}.html")), text).expect("a page");
    }
    for window in WINDOWS {
        for scheme in SCHEMES {
            let place = format!("{name} {} {scheme}", window.0);
            show(browser, &file, window, scheme);
            let dark = browser
                .evaluate("getComputedStyle(document.body).backgroundColor === 'rgb(20, 23, 27)'");
            assert_eq!(dark, json!(scheme == "dark"), "{place}");
            keep_shot(browser, &place.replace(' ', "-"));
            check(browser, window.0, &place);
            browser.evaluate("document.querySelectorAll('details').forEach(d => d.open = true)");
            check(browser, window.0, &format!("{place}, unfolded"));
            assert_eq!(complaints(browser), [""; 0], "{place}");
        }
    }
}

fn check(browser: &mut Browser, width: u32, place: &str) {
    let sizes = browser.evaluate("[innerWidth, document.documentElement.scrollWidth]");
    assert_eq!(sizes, json!([width, width]), "{place}");
    assert_eq!(browser.evaluate(BEYOND), json!([]), "{place}");
    assert_eq!(browser.evaluate(CUT), json!([]), "{place}");
    let contrast = browser.evaluate(CONTRAST).as_f64().expect("a number");
    assert!(contrast >= 4.5, "{place}: contrast {contrast}");
    let broken = "Array.from(document.images).filter(i => !i.complete || !i.naturalWidth).length";
    assert_eq!(browser.evaluate(broken), json!(0), "{place}");
}

#[test]
fn the_page_is_readable_narrow_and_wide_light_and_dark() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    look(&mut browser, "suite", &fixture::suite());
    look(&mut browser, "few", &fixture::few());
    look(&mut browser, "minimal", &fixture::minimal());
    look(&mut browser, "odd", &fixture::odd());
    look_at(
        &mut browser,
        "machines",
        &machines_page(&fixture::machines()),
    );
    let (old, new) = (fixture::few(), fixture::few());
    let changes = compare(&[("", &old), ("", &new)]);
    let baseline = (&old, &changes);
    look_at(
        &mut browser,
        "baseline",
        &page_against(&new, &[], Some(baseline)),
    );
}

fn machines_page(records: &[(&str, BenchRecord)]) -> String {
    let pairs: Vec<(&str, &BenchRecord)> = records.iter().map(|(name, r)| (*name, r)).collect();
    comparison_page(&pairs, &compare(&pairs))
}
