//! Places in a source that can be mutated.

use std::ops::Range;

use quote::ToTokens;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr, ReturnType, Type, UnOp};

/// A place, and the change there.
pub(crate) struct Site {
    /// Bytes of the expression, or of the body of a function.
    pub(crate) whole: Range<usize>,
    pub(crate) change: Change,
}

/// A change of an expression or of a function.
pub(crate) enum Change {
    /// Bytes to be replaced within the expression.
    Replace(Range<usize>, &'static str),
    /// A constant of type f32 or f64 is zero.
    Zero,
    /// A function returns this at once.
    Return(&'static str),
}

impl Change {
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Replace(_, "") => "operator taken away".into(),
            Self::Replace(_, by) => format!("-> {by}"),
            Self::Zero => "-> 0.0".into(),
            Self::Return(what) => format!("return {what}"),
        }
    }
}

/// Names of the constants of type f32 or f64 in a source.
pub(crate) fn constants(text: &str) -> Result<Vec<String>, String> {
    struct Names(Vec<String>);
    impl Names {
        fn add(&mut self, name: &syn::Ident, ty: &Type) {
            if matches!(&*ty.to_token_stream().to_string(), "f32" | "f64") {
                self.0.push(name.to_string());
            }
        }
    }
    impl<'a> Visit<'a> for Names {
        fn visit_item_const(&mut self, item: &'a syn::ItemConst) {
            self.add(&item.ident, &item.ty);
        }
        fn visit_impl_item_const(&mut self, item: &'a syn::ImplItemConst) {
            self.add(&item.ident, &item.ty);
        }
    }
    let mut names = Names(Vec::new());
    names.visit_file(&syn::parse_file(text).map_err(|e| e.to_string())?);
    Ok(names.0)
}

/// All places of a source, in its order.
pub(crate) fn find(text: &str, constants: &[String]) -> Result<Vec<Site>, String> {
    let mut finder = Finder { constants, sites: Vec::new() };
    finder.visit_file(&syn::parse_file(text).map_err(|e| e.to_string())?);
    finder.sites.sort_by_key(|s| (s.whole.start, s.whole.end));
    Ok(finder.sites)
}

struct Finder<'c> {
    constants: &'c [String],
    sites: Vec<Site>,
}

impl Finder<'_> {
    fn replace(&mut self, whole: &dyn Spanned, part: &dyn Spanned, by: &'static str) {
        let change = Change::Replace(part.span().byte_range(), by);
        self.sites.push(Site { whole: whole.span().byte_range(), change });
    }

    fn function(&mut self, attrs: &[syn::Attribute], sig: &syn::Signature, block: &syn::Block) {
        // The switch is no constant expression; and units are none of the sources.
        if sig.constness.is_some() || is_test(attrs) {
            return;
        }
        let returns: &[&'static str] = match &sig.output {
            ReturnType::Default => &["()"],
            ReturnType::Type(_, ty) => match &*ty.to_token_stream().to_string() {
                "bool" => &["true", "false"],
                "f32" | "f64" => &["0.0"],
                "usize" | "u8" | "u16" | "u32" | "u64" | "i32" | "i64" => &["0"],
                t if t.starts_with("Option <") => &["None"],
                t if t.starts_with("Vec <") => &["alloc::vec::Vec::new()"],
                _ => &[],
            },
        };
        for &what in returns {
            let whole = block.span().byte_range();
            self.sites.push(Site { whole, change: Change::Return(what) });
        }
        visit::visit_block(self, block);
    }
}

/// Whether an item is built for tests only, or for what tests ask for.
fn is_test(attrs: &[syn::Attribute]) -> bool {
    attrs.iter().any(|a| {
        let text = a.to_token_stream().to_string();
        text.contains("cfg (test)") || text.contains("# [test]") || text.contains("debug_assert")
    })
}

fn has_let(e: &Expr) -> bool {
    match e {
        Expr::Let(_) => true,
        Expr::Binary(b) => has_let(&b.left) || has_let(&b.right),
        _ => false,
    }
}

/// Replacements of an operator.
fn others(op: &BinOp) -> &'static [&'static str] {
    match op {
        BinOp::Lt(_) => &["<=", ">="],
        BinOp::Le(_) => &["<", ">"],
        BinOp::Gt(_) => &[">=", "<="],
        BinOp::Ge(_) => &[">", "<"],
        BinOp::Eq(_) => &["!="],
        BinOp::Ne(_) => &["=="],
        BinOp::Add(_) => &["-"],
        BinOp::Sub(_) => &["+"],
        BinOp::Mul(_) => &["/"],
        BinOp::Div(_) | BinOp::Rem(_) => &["*"],
        BinOp::And(_) => &["||"],
        BinOp::Or(_) => &["&&"],
        BinOp::BitAnd(_) => &["|"],
        BinOp::BitOr(_) => &["&"],
        BinOp::BitXor(_) => &["&"],
        BinOp::Shl(_) => &[">>"],
        BinOp::Shr(_) => &["<<"],
        BinOp::AddAssign(_) => &["-="],
        BinOp::SubAssign(_) => &["+="],
        BinOp::MulAssign(_) => &["/="],
        BinOp::DivAssign(_) => &["*="],
        BinOp::BitAndAssign(_) => &["|="],
        BinOp::BitOrAssign(_) => &["&="],
        _ => &[],
    }
}

impl<'a> Visit<'a> for Finder<'_> {
    fn visit_item_mod(&mut self, item: &'a syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    // Constant expressions cannot ask the switch.
    fn visit_item_const(&mut self, _: &'a syn::ItemConst) {}
    fn visit_item_static(&mut self, _: &'a syn::ItemStatic) {}
    fn visit_impl_item_const(&mut self, _: &'a syn::ImplItemConst) {}
    fn visit_trait_item_const(&mut self, _: &'a syn::TraitItemConst) {}
    fn visit_type(&mut self, _: &'a Type) {}
    fn visit_generic_argument(&mut self, _: &'a syn::GenericArgument) {}
    fn visit_pat(&mut self, _: &'a syn::Pat) {}
    fn visit_attribute(&mut self, _: &'a syn::Attribute) {}
    fn visit_expr_const(&mut self, _: &'a syn::ExprConst) {}
    fn visit_expr_repeat(&mut self, e: &'a syn::ExprRepeat) {
        self.visit_expr(&e.expr);
    }

    fn visit_item_fn(&mut self, f: &'a syn::ItemFn) {
        self.function(&f.attrs, &f.sig, &f.block);
    }

    fn visit_impl_item_fn(&mut self, f: &'a syn::ImplItemFn) {
        self.function(&f.attrs, &f.sig, &f.block);
    }

    fn visit_trait_item_fn(&mut self, f: &'a syn::TraitItemFn) {
        if let Some(block) = &f.default {
            self.function(&f.attrs, &f.sig, block);
        }
    }

    fn visit_expr_binary(&mut self, e: &'a syn::ExprBinary) {
        if !has_let(&e.left) && !has_let(&e.right) {
            for other in others(&e.op) {
                self.replace(e, &e.op, other);
            }
        }
        visit::visit_expr_binary(self, e);
    }

    fn visit_expr_unary(&mut self, e: &'a syn::ExprUnary) {
        if matches!(e.op, UnOp::Not(_) | UnOp::Neg(_)) && !matches!(*e.expr, Expr::Lit(_)) {
            self.replace(e, &e.op, "");
        }
        visit::visit_expr_unary(self, e);
    }

    fn visit_expr_method_call(&mut self, e: &'a syn::ExprMethodCall) {
        let other = match (&*e.method.to_string(), e.args.len()) {
            ("min", 1) => Some("max"),
            ("max", 1) => Some("min"),
            ("any", 1) => Some("all"),
            ("all", 1) => Some("any"),
            _ => None,
        };
        if let Some(other) = other {
            self.replace(e, &e.method, other);
        }
        visit::visit_expr_method_call(self, e);
    }

    fn visit_expr_path(&mut self, e: &'a syn::ExprPath) {
        let last = e.path.segments.last().map(|s| s.ident.to_string()).unwrap_or_default();
        if self.constants.contains(&last) {
            self.sites.push(Site { whole: e.span().byte_range(), change: Change::Zero });
        }
    }
}
