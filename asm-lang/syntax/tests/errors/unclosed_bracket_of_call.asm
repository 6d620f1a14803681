asm unclosed_bracket_of_call
signature:
definitions:
  main rule r_Main =
    if isDef(a then skip endif //~ L031
