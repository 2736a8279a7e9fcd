pub(super) fn run(_: &super::args::BenchArguments) -> super::Outcome {
    todo!()
}
