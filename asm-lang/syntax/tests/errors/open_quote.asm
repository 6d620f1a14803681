asm open_quote
signature:
definitions:
  rule r_a = a := "text //~ L004
  main rule r_Main = skip
