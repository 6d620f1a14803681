asm qualified_element
signature:
definitions:
  rule r_a = if mode = Mode.RUN then mode := Mode::STOP endif //~ L080 L080
  rule r_b = switch mode case Mode.RUN: skip case STOP: skip endswitch //~ L080
  main rule r_Main = n := f(Mode.RUN, 1.5) //~ L080
