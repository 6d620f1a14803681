asm unknown_word_endif
signature:
definitions:
  main rule r_Main =
    par
      if a = 1 then b := 1 end //~ L053
      a := 1
    endpar
