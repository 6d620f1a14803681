asm too_large
signature:
definitions:
  main rule r_Main = a := 9223372036854775808 //~ L006
