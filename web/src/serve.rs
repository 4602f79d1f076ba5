//! A web server for this machine alone: the files of a folder, as they are.

use std::error::Error;
use std::path::{Component, Path};
use tiny_http::{Header, Method, Response, Server};

/// Serves a folder until it is interrupted.
pub fn serve(folder: &Path, port: u16) -> Result<(), Box<dyn Error>> {
    let server = Server::http(("127.0.0.1", port))
        .map_err(|error| format!("port {port} of this machine cannot be served: {error}"))?;
    println!("http://{}/ (Ctrl-C ends it)", server.server_addr());
    for request in server.incoming_requests() {
        let path = request.url().split(['?', '#']).next().unwrap_or_default();
        let relative = Path::new(path.trim_start_matches('/'));
        let is_inside = relative.components().all(|part| matches!(part, Component::Normal(_)));
        let mut file = folder.join(relative);
        if file.is_dir() {
            file.push("index.html");
        }
        let is_read = matches!(request.method(), Method::Get | Method::Head);
        let contents = if is_inside && is_read { std::fs::read(&file).ok() } else { None };
        // Who asked may have gone.
        let _ = match contents {
            Some(bytes) => {
                let response = Response::from_data(bytes);
                let kind = Header::from_bytes("Content-Type", media_type(&file));
                request.respond(match kind {
                    Ok(kind) => response.with_header(kind),
                    Err(()) => response,
                })
            }
            None => request.respond(Response::from_string("not found").with_status_code(404)),
        };
    }
    Ok(())
}

fn media_type(file: &Path) -> &'static str {
    match file.extension().and_then(|extension| extension.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js" | "mjs") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("wasm") => "application/wasm",
        Some("json") => "application/json",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("woff2") => "font/woff2",
        _ => "application/octet-stream",
    }
}
