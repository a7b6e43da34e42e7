"""One good frame of every type of document 000 (docs/protocol.md, canonical frames)."""

SD = bytes.fromhex("405344" + "00" * 60 + "DC05" * 7 + "0C003000" + "F05C9375" + "24")
VS = (
    b"@VS2025-01-19-23:26:25,120.1535765,30.2874595,20,100,0,0,0,0,0,0,0,36,360,"
    + b"53191," * 9
    + b",".join([b"1200"] * 7)
    + b"$"
)

# type, the link that carries it, the frame
AUV = [
    ("auv.NI", "auv.to_pi", b"@NI$"),
    ("auv.AA", "auv.to_pi", b"@AA$"),
    ("auv.AC", "auv.to_pi", b"@AC$"),
    ("auv.AQ", "auv.to_pi", b"@AQ$"),
    ("auv.AE", "auv.to_pi", b"@AE$"),
    ("auv.DU", "auv.to_pi", b"@DU$"),
    ("auv.RI", "auv.to_stm32", b"@RI$"),
    ("auv.NS", "auv.to_pi", b"@NSCOOCCC$"),
    ("auv.RS", "auv.to_stm32", b"@RSCOOCCCO$"),
    ("auv.AW", "auv.to_pi", bytes.fromhex("40 41 57 01 00 01 00 5A 41 46 35 24")),
    ("auv.AO", "auv.to_pi", b"@AO,lamp,40,$"),
    ("auv.ST", "auv.to_pi", b"@ST,2025/01/11 16:56:06,$"),
    ("auv.SP", "auv.to_pi", b"@SP,1000,5,200,10,$"),
    ("auv.MT", "auv.to_stm32", b"@MT1,-10$"),
    ("auv.MD", "auv.to_stm32", b"@MDA2,-2$"),
    ("auv.D", "auv.to_stm32", b"@DA2,-2$"),
    ("auv.MM", "auv.to_stm32", b"@MMF12$"),
    ("auv.MR", "auv.to_stm32", b"@MRL5$"),
    ("auv.MS", "auv.to_stm32", b"@MS120,-90$"),
    ("auv.MP", "auv.to_stm32", b"@MP120,-90$"),
    ("auv.ZA", "auv.to_stm32", b"@ZAF5$"),
    ("auv.ZA", "auv.to_stm32", b"@ZAS30$"),
    ("auv.ZA", "auv.to_stm32", b"@ZAX0$"),
    ("auv.ZA", "auv.to_pi", b"@ZAWF$"),
    ("auv.ZA", "auv.to_stm32", b"@ZAA-5;3$"),
    ("auv.ACK", "auv.to_topside", b"@ACK_NSS$"),
    ("auv.ACK", "auv.to_topside", b"@ACK_AAA$"),
    ("auv.ACK", "auv.to_topside", b"@ACK_STT$"),
    ("auv.ACK", "auv.to_topside", b"@ACK_NI$$"),
    ("auv.ACK", "auv.from_stm32", b"@ACK_RSS$"),
    ("auv.ACK", "auv.from_stm32", b"@ACK_RI@$"),
    ("auv.ACK", "auv.to_topside", b"@ACK_NI1$"),
    ("auv.ACK", "auv.from_stm32", b"@ACK_RIQ$"),
    ("auv.ACK", "auv.from_stm32", b"@ACK_ZFY$"),
    ("auv.VS", "auv.to_topside", VS),
    ("auv.AR", "auv.to_topside", b"@AR,staging,9,5,3-5.9,0123456789abcdef,line 3: no bound,$"),
    ("auv.AES", "auv.to_topside", b"@AE,1,AU,Y,1,423,38,-120,45,7,860,31,1.9,0,F50%H90S3,row,$"),
    ("auv.SD", "auv.from_stm32", SD),
    ("auv.MODEM", "auv.modem", bytes.fromhex("23 02 04 00 01 40 44 55 24 14 86")),
    (
        "auv.MODEM",
        "auv.modem",
        bytes.fromhex("23 02 09 00 02 40 41 43 4B 5F 4E 49 24 24 F3 DE"),
    ),
]
