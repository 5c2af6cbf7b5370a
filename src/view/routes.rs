//! Everything that a request may ask for, and the answers.

use super::answer_memory::AnswerMemory;
use super::connection::{Connection, Request, Response};
use super::document;
use super::guard::{NO_SLASH, random_hex};
use super::protocol::Asking;
use super::queue::{PageAnswer, Task};
use super::served_scene::ServedScene;
use super::viewed_scene::{FILE_BYTES, FRAME_BYTES};
use serde::Deserialize;
use serde_json::{Value, json};
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

/// Interval at which a waiting thread looks whether its page is still there.
const LOOK: Duration = Duration::from_millis(100);

/// Type of a body that is just bytes.
const BYTES: &str = "application/octet-stream";

/// The answer to an admitted request for this name; `None` if nobody waits for it any more.
pub(super) fn respond(
    request: &Request,
    name: &str,
    connection: &Connection,
    served: &ServedScene,
) -> Option<Response> {
    if !request.is_post {
        return Some(match name {
            "" => match random_hex() {
                Ok(nonce) => document::page(&nonce),
                Err(error) => refusal(500, &error.to_string()),
            },
            NO_SLASH => Response::new(307, "text/plain", Vec::new())
                .with_header("Location", served.guard.path()),
            _ => refusal(404, "there is nothing here"),
        });
    }
    let asking: Asking = match serde_json::from_slice(&request.body) {
        Ok(asking) => asking,
        Err(error) => return Some(refusal(400, &error.to_string())),
    };
    let page = &asking.page;
    if page.len() != 16 || !page.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return Some(refusal(400, "a page has a name of 16 hexadecimal digits"));
    }
    let task = match name {
        "state" if served.queue.greet(page) => return Some(json_response(200, &served.state())),
        "state" => return Some(crowded()),
        "leave" => {
            served.queue.leave(page);
            return Some(empty());
        }
        "frame" => parsed(request).map(Task::Frame),
        "pixel" => parsed(request).map(Task::Pixel),
        "command" => parsed(request).map(Task::Command),
        "exposure" => parsed(request).map(Task::Exposure),
        "save" => parsed(request).map(Task::Save),
        _ => return Some(refusal(404, "there is nothing here")),
    };
    match task.and_then(Task::checked) {
        Err(reason) => Some(refusal(400, &reason)),
        Ok(_) if !served.is_ready() => Some(refusal(409, "the scene is not ready yet")),
        Ok(task) => wait(page, task, connection, served),
    }
}

fn parsed<'a, T: Deserialize<'a>>(request: &'a Request) -> Result<T, String> {
    serde_json::from_slice(&request.body).map_err(|error| error.to_string())
}

/// Waits for the answer to a task, as long as the page is there.
fn wait(page: &str, task: Task, connection: &Connection, served: &ServedScene) -> Option<Response> {
    let is_file = matches!(task, Task::Save(_));
    let pixel_bytes = if is_file { FILE_BYTES } else { FRAME_BYTES };
    let bytes = task.shot().0.pixels() * pixel_bytes;
    let memory = AnswerMemory::take(&served.answer_bytes, bytes);
    let submitted = memory.and_then(|memory| Some((memory, served.queue.submit(page, task)?)));
    let Some((memory, (id, answer))) = submitted else {
        return Some(crowded());
    };
    loop {
        match answer.recv_timeout(LOOK) {
            Ok(answer) => return Some(response(task, answer).holding(memory)),
            // The page has left.
            Err(RecvTimeoutError::Disconnected) => return Some(empty()),
            Err(RecvTimeoutError::Timeout) if connection.is_open() => {}
            Err(RecvTimeoutError::Timeout) => {
                served.queue.withdraw(page, id);
                return None;
            }
        }
    }
}

fn response(task: Task, answer: PageAnswer) -> Response {
    match answer {
        PageAnswer::Json(json) => json_response(200, &json),
        PageAnswer::Nothing => empty(),
        PageAnswer::Refused(reason) => refusal(400, &reason),
        PageAnswer::Frame(picture) => {
            let is_jpeg = matches!(task, Task::Frame(request) if request.jpeg);
            let content_type = if is_jpeg { "image/jpeg" } else { BYTES };
            let (info, body) = picture.encode(is_jpeg);
            let info = serde_json::to_string(&info).unwrap_or_default();
            Response::new(200, content_type, body).with_header("Frame", info)
        }
        PageAnswer::File(name, contents) => {
            // The name has only plain characters.
            let disposition = format!("attachment; filename=\"{name}\"");
            Response::new(200, BYTES, contents).with_header("Content-Disposition", disposition)
        }
    }
}

fn json_response(status: u16, body: &Value) -> Response {
    Response::new(status, "application/json", body.to_string().into_bytes())
}

fn empty() -> Response {
    Response::new(204, "application/json", Vec::new())
}

fn crowded() -> Response {
    let reason = "too many pages look at this scene, or one asks for too much at once";
    refusal(503, reason)
}

/// An answer that says why there is none.
pub(super) fn refusal(status: u16, reason: &str) -> Response {
    json_response(status, &json!({ "error": reason }))
}
