asm unknown_word_then
signature:
definitions:
  main rule r_Main = if a = 1 thn b := 1 endif //~ L053
