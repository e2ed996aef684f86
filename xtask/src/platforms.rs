//! The same answers on other machines: built for each, run under emulation where this machine is
//! none, and held against its own.

mod built;
mod targets;
mod windows;

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use crate::bindings::golden;
use crate::compiler::{Compiler, words};
use crate::cross;
use crate::runner::{End, Ended, Skip};
use crate::tools::{
    Done, command, install, install_words, is_ci, is_set, is_whole, output, root, run,
};
use built::{Built, built, cargo, folder, text};
use targets::{Further, Target, WITHOUT_FMA};

/// The program whose lines must be the same.
const PROGRAM: &str = "everywhere";

/// Whether this machine's answers are those that others' are held against.
const IS_HERE: bool = cfg!(all(target_arch = "x86_64", target_os = "linux", target_env = "gnu"));

/// The step: all that there are compilers and emulators for.
pub(crate) fn test() -> Ended {
    if !IS_HERE {
        let what = "the answers of other machines beside this one's";
        return Ok(End::Skipped(Skip::new(what, "they are held against those of x86-64 Linux")));
    }
    let mut skips = Vec::new();
    build(&targets::HOST)?;
    let own = everywhere(&targets::HOST);
    let lines = printed(own.command(&[]))?;
    println!("{} answers of this machine", lines.len());
    let mut without = own.command(&[]);
    without.env("GLIBC_TUNABLES", WITHOUT_FMA);
    compare("without fused multiply-add", &lines, &printed(without)?)?;
    for target in others() {
        if !is_there(target, &mut skips)? {
            continue;
        }
        if target.further == Further::Programs {
            cross::prepare_wine()?;
        }
        build(target)?;
        compare(target.name, &lines, &printed(everywhere(target).command(&[]))?)?;
        if target.c_compiler.is_some() {
            c_library(target)?;
        }
        match target.further {
            Further::None => {}
            Further::Engine => engine_tests(target, &[], FEW)?,
            Further::Programs => windows::test(target)?,
        }
    }
    for target in targets::CHECKED {
        match Compiler::find(target.name)? {
            Some(compiler) => run(compiler.cargo(target.check, target.name, &folder()))?,
            None => {
                skips.push(Skip::new(format!("a check for {}", target.name), words(target.name)));
            }
        }
    }
    Ok(if skips.is_empty() { End::Passed } else { End::Partly(skips) })
}

/// Whether a target's compilers and emulator are there, once CI has installed them.
fn is_there(target: &Target, skips: &mut Vec<Skip>) -> Result<bool, String> {
    let what = || format!("answers on {}", target.name);
    if Compiler::find(target.triple)?.is_none() {
        skips.push(Skip::new(what(), words(target.triple)));
        return Ok(false);
    }
    let has = || output("sh", &["-c", target.probe]).is_some();
    if !has() && is_ci() {
        install(target.packages)?;
        if !has() {
            return Err(format!(
                "{} were installed, but cannot be run",
                target.packages.join(", ")
            ));
        }
    }
    if !has() {
        skips.push(Skip::new(what(), install_words(target.packages)));
        return Ok(false);
    }
    Ok(true)
}

/// Builds all of it that needs nothing installed, before the step.
pub(crate) fn build_ahead() -> Done {
    if !IS_HERE {
        return Ok(());
    }
    build(&targets::HOST)?;
    let has_runner = |target: &&Target| output("sh", &["-c", target.probe]).is_some();
    let is_there = |target: &&Target| Compiler::installed(target.triple).is_some();
    others().filter(is_there).filter(has_runner).try_for_each(build)?;
    let mut checked =
        targets::CHECKED.iter().filter_map(|c| Some((c, Compiler::installed(c.name)?)));
    checked.try_for_each(|(c, compiler)| run(compiler.cargo(c.check, c.name, &folder())))
}

/// The other machines that answers are compared with.
fn others() -> impl Iterator<Item = &'static Target> {
    targets::OTHERS.iter().filter(|target| is_whole() || !target.is_like_another)
}

/// Builds what is run for a target: the program of answers, the C library, and what goes further.
fn build(target: &Target) -> Done {
    let words = ["build", "--package", "cullet-lab", "--bin", PROGRAM, "--no-default-features"];
    let mut features = vec![PROGRAM];
    // Of x86 the scalar level is the host's.
    features.extend(target.has_scalar.then_some("force_support_fallback"));
    let mut answers = cargo(target, &words);
    answers.args(["--features", &features.join(",")]);
    run(answers)?;
    if target.c_compiler.is_some() {
        run(cargo(target, &["build", "--package", "cullet-c"]))?;
    }
    match target.further {
        Further::None => Ok(()),
        Further::Engine => engine_tests(target, &["--no-run"], &[]),
        Further::Programs => windows::build(target),
    }
}

/// The program of answers.
fn everywhere(target: &Target) -> Built<'_> {
    Built { target, program: built(target, &format!("{PROGRAM}{}", target.ending)) }
}

/// The lines that a program prints, by their names.
fn printed(mut command: Command) -> Result<BTreeMap<String, String>, String> {
    println!("$ {command:?}");
    let out = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    let said = String::from_utf8_lossy(&out.stderr);
    print!("{said}");
    if !out.status.success() {
        return Err(format!("{command:?}: {}", out.status));
    }
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    let pair = |line: &str| line.split_once('\t').map(|(a, b)| (a.to_owned(), b.to_owned()));
    Ok(text.lines().filter_map(pair).collect())
}

/// Holds the lines of another machine against this one's.
fn compare(
    name: &str,
    expected: &BTreeMap<String, String>,
    found: &BTreeMap<String, String>,
) -> Done {
    let differs = |(line, hash): &(&String, &String)| found.get(*line) != Some(*hash);
    let wrong: Vec<_> = expected.iter().filter(differs).map(|(line, _)| line.as_str()).collect();
    let too_many = found.keys().filter(|line| !expected.contains_key(*line)).count();
    if wrong.is_empty() && too_many == 0 && !found.is_empty() {
        println!("{name}: {} answers, all equal", found.len());
        return Ok(());
    }
    let others =
        if wrong.len() > 8 { format!(" and {} more", wrong.len() - 8) } else { String::new() };
    Err(format!("{name} answers otherwise: {}{others}", wrong[..wrong.len().min(8)].join("; ")))
}

/// The C library and two of its tests, the golden answers among them.
fn c_library(target: &Target) -> Done {
    let Some(compiler) = target.c_compiler else { return Ok(()) };
    let source = root().join("bindings/c");
    let work = folder().join(target.triple).join("c");
    fs::create_dir_all(&work).map_err(|e| format!("{}: {e}", work.display()))?;
    let golden = text(&golden::folder());
    for (test, args) in [("mistakes", &[][..]), ("golden", &[golden.as_str()][..])] {
        let program = work.join(format!("{test}{}", target.ending));
        let mut compile = command(compiler[0], &compiler[1..]);
        compile.args(["-std=c11", "-O1"]).arg(source.join(format!("tests/{test}.c")));
        compile.arg("-I").arg(source.join("include")).arg("-o").arg(&program);
        compile.arg(built(target, target.c_library)).args(target.c_flags);
        run(compile)?;
        run(Built { target, program }.command(args))?;
    }
    Ok(())
}

/// Names of the engine's tests that are run where not all are.
const FEW: &[&str] = &["simd_levels", "occlusion::", "hierarchy"];

/// The engine's tests by themselves, some of their cases, by names; with `CULLET_ALL=1` all tests.
fn engine_tests(target: &Target, options: &[&str], names: &[&str]) -> Done {
    let scalar = "cullet/force_support_fallback";
    let mut units =
        cargo(target, &["test", "--lib", "--package", "cullet", "--package", "cullet-cells"]);
    units.args(["--features", scalar]).args(options).env("CULLET_CASES", "20");
    run(units)?;
    let mut programs = vec!["test", "--package", "cullet-testkit", "--test", "cullet"];
    let all = is_set("CULLET_ALL", "1");
    if all {
        programs.extend(["--test", "cells", "--test", "cullet_lod", "--test", "cullet_stand_ins"]);
    }
    let mut programs = cargo(target, &programs);
    programs.args(["--features", "cullet-testkit/force_support_fallback"]).args(options);
    if !all {
        programs.env("CULLET_CASES", "4").arg("--").args(names);
    }
    run(programs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(of: &[(&str, &str)]) -> BTreeMap<String, String> {
        of.iter().map(|&(a, b)| (a.to_owned(), b.to_owned())).collect()
    }

    #[test]
    fn answers_are_equal_or_named() {
        let own = lines(&[("city: views", "1"), ("city: levels", "2"), ("sin", "3")]);
        assert_eq!(compare("x", &own, &own), Ok(()));
        for (other, named) in [
            (lines(&[("city: views", "1"), ("city: levels", "2"), ("sin", "4")]), "sin"),
            (lines(&[("city: views", "1"), ("sin", "3")]), "city: levels"),
            (lines(&[("city: views", "1"), ("city: levels", "9"), ("sin", "3")]), "city: levels"),
            (lines(&[("city: views", "1"), ("sin", "3"), ("cos", "3")]), "x answers otherwise"),
            (lines(&[]), "city: views"),
        ] {
            let why = compare("x", &own, &other).expect_err(named);
            assert!(why.contains(named), "{why}");
        }
    }
}
