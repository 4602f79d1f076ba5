//! The engine without a browser: takes a scene and a job as JSON, and prints the result, which a
//! browser's is compared with.

use pathspace_web::Lesson;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (Some(scene), Some(job), None) = (arguments.next(), arguments.next(), arguments.next())
    else {
        eprintln!("usage: native SCENE JOB, both JSON as the page's");
        return ExitCode::from(2);
    };
    match rendered(&scene, &job) {
        Ok(result) => {
            println!("{result}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn rendered(scene: &str, job: &str) -> Result<String, Box<dyn std::error::Error>> {
    let lesson = Lesson::new(&serde_json::from_str(scene)?, None)?;
    let mut mean = [0.0; 3];
    let finished = lesson.render(&serde_json::from_str(job)?, &mut |_, image| {
        let (pixels, _) = image.as_chunks::<3>();
        let sum = |c: usize| pixels.iter().map(|pixel| f64::from(pixel[c])).sum::<f64>();
        mean = [0, 1, 2].map(|c| sum(c) / pixels.len() as f64);
        false
    })?;
    Ok(serde_json::to_string(&serde_json::json!({ "finished": finished, "mean": mean }))?)
}
