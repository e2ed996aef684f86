//! `cullet quiz`: the exercises of the book, and whether an answer is right.

mod exercise;

use clap::Args;
use cullet_command::console::{Console, count};
use cullet_command::exit::{Exit, Failure, Outcome};

pub use exercise::{Answer, Exercise, Judged, NoAnswer, exercises};

/// End of `cullet quiz --help`.
pub(crate) const HELP: &str = "\
Each chapter of the book ends with exercises. A number may be given with its unit or as per cent, with three
digits where it is not whole; of a choice, the word.

Examples
  cullet quiz                    all exercises, chapter by chapter
  cullet quiz frustum            those of a chapter
  cullet quiz frustum-1          one question
  cullet quiz frustum-1 2.5      is 2.5 the answer? Exit code 0 if it is, 1 if not
  cullet quiz frustum-1 --solve  the answer, and why";

/// `cullet quiz`
#[derive(Debug, Args)]
pub struct QuizArgs {
    /// An exercise, or the beginning of its name
    exercise: Option<String>,
    /// Your answer
    #[arg(allow_negative_numbers = true)]
    answer: Option<String>,
    /// Tell the answer, and why
    #[arg(long, conflicts_with = "answer", requires = "exercise")]
    solve: bool,
}

/// Runs the command.
pub(crate) fn run(args: &QuizArgs, console: &Console) -> Outcome {
    let all = exercises().map_err(|e| Failure { exit: Exit::Internal, message: e })?;
    let Some(name) = &args.exercise else {
        print_list(&all, console);
        console.line("");
        console.line("cullet quiz NAME asks one, cullet quiz NAME ANSWER says whether it is right");
        return Ok(Exit::Fine);
    };
    let Some(exercise) = all.iter().find(|e| e.id == name) else {
        let some: Vec<Exercise> =
            all.into_iter().filter(|e| e.id.starts_with(name.as_str())).collect();
        if some.is_empty() || args.answer.is_some() || args.solve {
            return Err(Failure::usage(format!(
                "there is no exercise '{name}': cullet quiz lists them all"
            )));
        }
        print_list(&some, console);
        return Ok(Exit::Fine);
    };
    let Some(answer) = &args.answer else {
        console.line(question(exercise));
        if args.solve {
            console.line(format!("\n{}", exercise.solution));
        }
        return Ok(Exit::Fine);
    };
    let not = |how: &str| {
        console.line(format!(
            "{how} docs/src/{} explains it; `cullet quiz {name} --solve` tells the answer",
            exercise.chapter
        ));
        Ok(Exit::FalseCull)
    };
    match exercise.judge(answer) {
        Ok(Judged::Right) => {
            console.line(format!("Right. {}", exercise.solution));
            Ok(Exit::Fine)
        }
        Ok(Judged::Near) => not("Near, but not right: is it rounded to fewer than three digits?"),
        Ok(Judged::Wrong) => not("Not right."),
        Err(no_answer) => Err(Failure::usage(no_answer)),
    }
}

/// The question, and what may be answered.
fn question(exercise: &Exercise) -> String {
    let may = match (exercise.choices.as_slice(), exercise.unit) {
        ([], "") => "a number".to_owned(),
        ([], unit) => format!("a number of {unit}"),
        (choices, _) => choices.join(", "),
    };
    let context = if exercise.context.is_empty() { "" } else { "\n\n" };
    format!("{}{context}{}\n\nAnswer: {may}", exercise.context, exercise.question)
}

fn print_list(of: &[Exercise], console: &Console) {
    let mut chapter = "";
    for exercise in of {
        if exercise.chapter != chapter {
            chapter = exercise.chapter;
            let in_chapter = of.iter().filter(|e| e.chapter == chapter).count() as u64;
            console.line(format!("{chapter}, {}", count(in_chapter, "exercise", "exercises")));
        }
        console.line(format!("  {:<15} {}", exercise.id, exercise.question));
    }
}
