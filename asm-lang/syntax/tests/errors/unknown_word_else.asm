asm unknown_word_else
signature:
definitions:
  main rule r_Main =
      if a = 1 then b := 1 esle b := 2 endif //~ L053
