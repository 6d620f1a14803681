asm misspelled_end_before_init
signature:
definitions:
  main rule r_Main =
    switch a
      case 1: b := 2
    endswich //~ L053
default init s0:
  function a = 1
