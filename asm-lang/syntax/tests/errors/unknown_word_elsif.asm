asm unknown_word_elsif
signature:
definitions:
  main rule r_Main =
    if a = 1 then b := 1
    elsif a = 2 then b := 2 //~ ?
    endif
