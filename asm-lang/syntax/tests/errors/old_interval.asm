asm old_interval
signature:
definitions:
  main rule r_Main = s := {1..3} //~ L071
